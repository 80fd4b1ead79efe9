// Pages for people: self-contained, and harmless whatever stands in a user's files.

#include "report/report.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "report/page.hpp"
#include "report/support.hpp"
#include "support/command.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;

namespace {

/// Recordings of a pendulum with dry friction and a spec with a hostile name; the folder of its diagnosis.
std::filesystem::path diagnosed(const Folder& folder, const std::string& name) {
  std::string csv = "t,q,u\n";
  double q = 1.2, v = 0.0;
  constexpr double kStep = 1e-3;
  for (int k = 0; k < 8000; ++k) {
    if (k % 10 == 0) csv += std::to_string(kStep * k) + "," + std::to_string(q) + ",0\n";
    const double a = -9.81 * std::sin(q) - 0.2 * v - (v > 0.0 ? 0.15 : -0.15);
    v += kStep * a;
    q += kStep * v;
  }
  write_file(folder.path() / "train.csv", csv);
  write_file(folder.path() / "spec.yaml",
             "name: " + name +
                 "\nmodel: {plant: pendulum, parameters: {mass: 1, length: 1, friction: 0.2}}\n"
                 "signals: {time: t, position: q, input: u}\nrecordings: [train.csv]\n");
  const auto out = folder.path() / "out";
  const CommandResult result = bayesctrl_with({"diagnose", folder.path() / "spec.yaml", "--out", out, "--quiet"});
  INFO(result.err);
  REQUIRE(result.status == 0);
  return out;
}

}  // namespace

TEST_CASE("The report of a diagnosis is one page that asks for nothing and runs nothing of the user's",
          "[report][slow]") {
  const Folder folder;
  const auto out = diagnosed(folder, "\"<script>alert(1)</script> & co\"");
  const std::string html = read_file(out / "report.html", 10'000'000);
  CHECK(html.size() < 3'000'000);
  CHECK_THAT(html, !Contains("<script>alert"));
  CHECK_THAT(html, Contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp; co"));
  CHECK(count(html, "<script") == 3);
  CHECK(count(html, "</script>") == 3);
  CHECK_THAT(html, !Contains(" src=") && !Contains("@import"));
  CHECK_THAT(html, Contains("The model lacks Coulomb friction (level 0.15"));
  CHECK_THAT(html, Contains("MIT"));

  // The data in the page are those of the files.
  const nlohmann::ordered_json data = data_of(html);
  CHECK(data["diagnosis"] == nlohmann::ordered_json::parse(read_file(out / "diagnosis.json", 10'000'000)));
  CHECK(data["runs"].size() == 1);
  CHECK(data["runs"][0]["joints"][0]["measured"].size() == 800);
  CHECK(data["torque"][0]["joints"][0]["v"].size() == 800);

  // `report` writes the same page from the files.
  std::filesystem::remove(out / "report.html");
  CHECK(bayesctrl_with({"report", out}).status == 0);
  CHECK(read_file(out / "report.html", 10'000'000) == html);
}

TEST_CASE("With --no-report there is none, and a folder without results has none", "[report][slow]") {
  const Folder folder;
  const auto out = diagnosed(folder, "plain");
  std::filesystem::remove(out / "report.html");
  CHECK(bayesctrl_with({"diagnose", folder.path() / "spec.yaml", "--out", out, "--quiet", "--no-report"}).status == 0);
  CHECK_FALSE(std::filesystem::exists(out / "report.html"));
  CHECK_THROWS_AS(report({folder.path()}), IoError);
}

TEST_CASE("Text in pages is escaped", "[report]") {
  CHECK(escaped("<a href=\"x\">&</a>") == "&lt;a href=&quot;x&quot;&gt;&amp;&lt;/a&gt;");
  const std::string html = page("t", "", {{"text", "</script><script>alert(2)</script>"}});
  CHECK_THAT(html, !Contains("alert(2)</script>"));
}

TEST_CASE("The report of a trial shows what was said for what", "[report]") {
  const Folder folder;
  write_file(folder.path() / "summary.json", R"({"cases": 3, "seed": 7})");
  write_file(folder.path() / "cases.csv",
             "case,family,truth,hidden,verdict,said,probability,named\n"
             "a,single,input_gain,input_gain,named,input_gain,0.99,1\n"
             "b,single,input_gain,input_gain@2,named,sensor_scale@2,0.95,0\n"
             "c,nothing,nothing,-,nothing_missing,-,1,0\n"
             "d,outside,magnetic_latch,magnetic_latch,unknown,-,0,0\n"
             "e,pair,pair,linear_spring + input_gain,named,linear_spring,0.97,0\n");
  const std::string html = report({folder.path()});
  CHECK_THAT(html, Contains(R"(["input_gain",2,1,"sensor_scale@2",0])"));
  CHECK_THAT(html, Contains(R"(["nothing",1,1,"",0])"));
  CHECK_THAT(html, Contains(R"(["outside: magnetic_latch",1,0,"",1])"));
  CHECK_THAT(html, Contains(R"(["pair",1,0,"linear_spring for linear_spring + input_gain",0])"));
  CHECK_THAT(html, Contains(R"({"hidden":"input_gain","said":{"input_gain":1,"sensor_scale":1}})"));
  CHECK_THAT(html, Contains(R"("cases":3.0)"));
}

TEST_CASE("Damaged results of a diagnosis or a trial are told, with their place", "[report][slow]") {
  const Folder folder;
  const auto error = [&] { return io_examples::error_of<DataError>([&] { report({folder.path()}); }); };
  write_file(folder.path() / "diagnosis.json", "{\"name\": ");
  CHECK_THAT(error(), Contains("diagnosis.json: ") && Contains("parse error"));
  write_file(folder.path() / "diagnosis.json", R"({"name": "x", "verdict": "named"})");
  CHECK_THAT(error(), Contains("damaged or of another version") && Contains("reason"));
  const auto out = diagnosed(folder, "plain");
  write_file(out / "fit.csv", "set,recording,t\ntrain,a,0\n");
  CHECK_THAT(io_examples::error_of<DataError>([&] { report({out}); }), Contains("fit.csv: has no column 'measured'"));
  std::filesystem::remove(folder.path() / "diagnosis.json");
  write_file(folder.path() / "summary.json", "{}");
  write_file(folder.path() / "cases.csv", "case,family,verdict,probability,named\na,single,named,0.99,1\n");
  CHECK_THAT(error(), Contains("cases.csv: has no column 'truth'"));
}
