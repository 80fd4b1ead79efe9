#include "inspect/starter.hpp"

#include <catch2/catch.hpp>

#include "diagnose/recording/read_recording.hpp"
#include "experiment/read.hpp"
#include "inspect/columns.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/text.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

/// A recording with this header and as many columns of numbers, one row each `step`.
std::string csv(const std::string& header, double step = 0.01) {
  const auto columns = 1 + std::count(header.begin(), header.end(), ',');
  std::string text = header + "\n";
  for (int row = 0; row < 30; ++row) {
    text += std::to_string(step * row);
    for (long i = 1; i < columns; ++i) text += "," + std::to_string(0.1 * static_cast<double>(row * i));
    text += "\n";
  }
  return text;
}

ColumnGuesses guesses(const std::string& header) {
  return guess_columns(parse_data_csv(csv(header), "x.csv"), "x.csv");
}

std::string columns(const std::vector<ColumnGuess>& list) {
  std::string text;
  for (const ColumnGuess& guess : list) text += (text.empty() ? "" : " ") + guess.column;
  return text;
}

DiagnosisSpec starter(const Folder& folder, const std::vector<fs::path>& files, const std::string& plant = "") {
  write_file(folder.path() / "spec.yaml", diagnosis_starter(files, plant, folder.path()));
  return read_diagnosis_spec(folder.path() / "spec.yaml");
}

}  // namespace

TEST_CASE("The starter of an experiment runs with every plant and every controller succeeds", "[inspect]") {
  for (const std::string_view plant : names_of(static_cast<const Plant*>(nullptr))) {
    INFO(plant);
    const std::string text = experiment_starter(plant);
    INFO(text);
    Node spec = parse_yaml(text, "starter.yaml");
    set_path(spec, "duration=2");
    const Study study = read_studies(spec).front();
    CHECK(name_of(study.model.plant) == plant);
    for (const Outcome& outcome : run_one(study).outcomes) {
      INFO(outcome.controller << ": " << outcome.result.reason);
      CHECK(outcome.result.status == RunStatus::ok);
    }
    CHECK(std::count(text.begin(), text.end(), '#') > 20);  // commented
  }
  CHECK_THROWS_AS(experiment_starter("cart"), std::invalid_argument);
}

TEST_CASE("Columns are known by their names", "[inspect]") {
  struct Row {
    std::string header, time, position, velocity, input;
  };
  for (const Row& row : {Row{"t,q,qd,u", "t", "q", "qd", "u"},
                         Row{"time,position,velocity,torque", "time", "position", "velocity", "torque"},
                         Row{"Time (ms),Angle [deg],Omega [rpm],Torque [mNm]", "Time (ms)", "Angle [deg]",
                             "Omega [rpm]", "Torque [mNm]"},
                         Row{"u,x_mm,t_s", "t_s", "x_mm", "", "u"}, Row{"t,qm,qg,vir", "t", "qm", "", "qg"},
                         Row{"time,pos_des,pos_meas,tau_des,tau_meas", "time", "pos_meas", "", "tau_meas"},
                         Row{"time,pos_meas1,pos_meas2,vel_meas1,vel_meas2,tau_con1,tau_con2,tau_meas1,tau_meas2",
                             "time", "pos_meas1 pos_meas2", "vel_meas1 vel_meas2", "tau_meas1 tau_meas2"},
                         Row{"q2,q1,tau2,tau1", "", "q1 q2", "", "tau1 tau2"}}) {
    INFO(row.header);
    const ColumnGuesses found = guesses(row.header);
    CHECK((found.time ? found.time->column : "") == row.time);
    CHECK(columns(found.position) == row.position);
    CHECK(columns(found.velocity) == row.velocity);
    CHECK(columns(found.input) == row.input);
  }
}

TEST_CASE("Units in names become scales", "[inspect]") {
  const ColumnGuesses found = guesses("Time (ms),Angle [deg],Omega [rpm],Torque [mNm]");
  CHECK(found.time->scale == 1e-3);
  CHECK(found.position[0].scale == Approx(3.14159265 / 180.0));
  CHECK(found.position[0].unit == "rad");
  CHECK(found.velocity[0].scale == Approx(2.0 * 3.14159265 / 60.0));
  CHECK(found.input[0].scale == 1e-3);
  CHECK(found.input[0].unit == "N m");
  CHECK(guesses("t,q,u").position[0].unit.empty());
  CHECK(guesses("t,x_cm,u").position[0].scale == 1e-2);
}

TEST_CASE("A temperature is no input, and needs none of its own for each joint", "[inspect]") {
  const ColumnGuesses found = guesses("t,q1,q2,Motor temp [°F],u1,u2");
  CHECK(columns(found.input) == "u1 u2");
  REQUIRE(columns(found.temperature) == "Motor temp [°F]");
  CHECK(50.0 * found.temperature[0].scale + found.temperature[0].offset == Approx(10.0));
  CHECK(found.temperature[0].unit == "degC");
  CHECK(columns(guesses("t,q1,q2,temp1,T2 [celsius],u1,u2").temperature) == "temp1 T2 [celsius]");
  CHECK(guesses("t,q,u,w_k").temperature.empty());
  CHECK(columns(guesses("t,q(k),u(k),temp_K").position) == "q(k)");
  CHECK(guesses("t,q(k),u(k),temp_K").temperature.at(0).offset == -273.15);

  const Folder folder;
  const fs::path file = folder.path() / "a.csv";
  write_file(file, csv("T [K],t,q,u", 0.01));
  CHECK(starter(folder, {file}).signals.temperature.at(0).to_si()(300.0) == Approx(26.85));
}

TEST_CASE("A header that names no position or no input is refused with its columns", "[inspect]") {
  CHECK_THROWS_WITH(guesses("t,foo,bar"), Contains("x.csv:1") && Contains("position") && Contains("t, foo, bar"));
  CHECK_THROWS_WITH(guesses("t,q"), Contains("an input for each position"));
}

TEST_CASE("Columns that the user names need no guess", "[inspect]") {
  const Folder folder;
  const fs::path file = folder.path() / "a.csv";
  write_file(file, csv("Zeit,Winkel [deg],Moment", 0.01));
  CHECK_THROWS_WITH(diagnosis_starter({file}, "", folder.path()), Contains("name it with --position"));
  CHECK_THROWS_WITH(diagnosis_starter({file}, "", folder.path(), {.time = "Ziet", .position = {}, .input = {}}),
                    Contains("has no column 'Ziet', did you mean 'Zeit'?"));
  write_file(folder.path() / "spec.yaml",
             diagnosis_starter({file}, "", folder.path(),
                               {.time = "Zeit", .position = {"Winkel [deg]"}, .input = {"Moment"}}));
  const DiagnosisSpec spec = read_diagnosis_spec(folder.path() / "spec.yaml");
  CHECK(spec.signals.position.front().column == "Winkel [deg]");
  CHECK(spec.signals.position.front().scale == Approx(3.14159265 / 180.0));
  CHECK(spec.signals.input.front().column == "Moment");
}

TEST_CASE("Without names the column that runs on evenly is the time, whatever place it has", "[inspect]") {
  const auto time_of = [](const std::string& text) {
    const ColumnGuesses found =
        guess_columns(parse_data_csv(text, "x.csv"), "x.csv", {.time = "", .position = {"2"}, .input = {}});
    return found.time ? found.time->column : "";
  };
  CHECK(time_of("0,0.5,1\n0.01,0.4,1.2\n0.02,0.6,1.1\n0.03,0.3,0.9\n") == "1");
  CHECK(time_of("0.7,0.5,10\n0.1,0.4,20\n0.2,0.6,30\n0.3,0.3,40\n") == "3");
  CHECK(time_of("0.7,0.5,10\n0.1,0.4,20\n0.2,0.6,19\n0.3,0.3,40\n").empty());         // it runs backwards once
  CHECK(time_of("a,2,b\n0.7,0.5,10\n0.1,0.4,20\n0.2,0.6,30\n0.3,0.3,40\n").empty());  // names say otherwise
}

TEST_CASE("The starter of a diagnosis reads its recordings as they are", "[inspect]") {
  const Folder folder;
  write_file(folder.path() / "data" / "a b.csv", csv("time_ms,angle_deg,torque", 10.0));
  const DiagnosisSpec spec = starter(folder, {folder.path() / "data" / "a b.csv"});
  CHECK(spec.name == "a b");
  CHECK(std::holds_alternative<Pendulum>(*spec.model.plant));
  REQUIRE(spec.recordings.size() == 1);
  REQUIRE(spec.held_out.size() == 1);
  CHECK(spec.recordings[0].name == "data/a b.csv");
  const Measured train = read_recording(spec.recordings[0], spec.signals);
  const Measured test = read_recording(spec.held_out[0], spec.signals);
  CHECK(train.samples() == 20);
  CHECK(test.samples() == 10);
  CHECK(train.time[1] == Approx(0.01));
  CHECK(train.position(10, 0) == Approx(3.14159265 / 180.0));
}

TEST_CASE("Whatever bytes name the columns, the starter's spec finds them", "[inspect]") {
  const Folder folder;
  for (const std::string odd :
       {"\x1b[1m", "\a",   "\xb0", "\xe9\xe8", "#",        ": ",           "'", "\\", "- ", "\xf0\x9f\xa4\x96",
        "{",       "\x7f", "%",    "~",        "\xc2\x85", "\xe2\x80\xa8", "@", "!",  "&",  "null "}) {
    CAPTURE(odd);
    const std::string header = "t," + odd + " position," + odd + " torque";
    write_file(folder.path() / "odd.csv", csv(header));
    write_file(folder.path() / "spec.yaml",
               diagnosis_starter(
                   {folder.path() / "odd.csv"}, "", folder.path(),
                   {.time = "t", .position = {as_utf8(odd + " position")}, .input = {as_utf8(odd + " torque")}}));
    const DiagnosisSpec spec = read_diagnosis_spec(folder.path() / "spec.yaml");
    CHECK(read_recording(spec.recordings[0], spec.signals).samples() == 20);
  }
}

TEST_CASE("A recording in UTF-16 is read as the same in UTF-8", "[inspect]") {
  const Folder folder;
  const bool high_first = GENERATE(true, false);
  const std::u16string text = u"t,\u00e4ngle \u03c6 \U0001F916 position,torque\r\n";
  std::u16string rows;
  for (const char c : csv("x,y,z").substr(6)) rows += static_cast<char16_t>(c);
  std::string bytes = high_first ? "\xFE\xFF" : "\xFF\xFE";
  for (const char16_t unit : text + rows) {
    const char high = static_cast<char>(unit >> 8), low = static_cast<char>(unit & 0xff);
    bytes += high_first ? std::string{high, low} : std::string{low, high};
  }
  write_file(folder.path() / "wide.csv", bytes);
  const DiagnosisSpec spec = starter(folder, {folder.path() / "wide.csv"});
  CHECK(spec.signals.position.at(0).column == "\u00e4ngle \u03c6 \U0001F916 position");
  CHECK(read_recording(spec.recordings[0], spec.signals).samples() == 20);
}

TEST_CASE("The starter of a diagnosis says which columns it leaves out", "[inspect]") {
  const Folder folder;
  const auto text = [&](const std::string& header) {
    write_file(folder.path() / "a.csv", csv(header));
    return diagnosis_starter({folder.path() / "a.csv"}, "", folder.path());
  };
  CHECK_THAT(text("t,q,u,fan: a,note"), Contains("# left out, the recording has them too: \"fan: a\", note\n"));
  CHECK_THAT(text("t,q,u"), !Contains("left out"));
}

TEST_CASE("The starter of a diagnosis chooses a plant from the columns, and the last of several recordings is held out",
          "[inspect]") {
  const Folder folder;
  const auto write = [&](const std::string& name, const std::string& header, double step = 0.01) {
    write_file(folder.path() / name, csv(header, step));
    return folder.path() / name;
  };
  const fs::path slide = write("slide.csv", "t,x_mm,v_mm/s,force"), arm = write("arm.csv", "t,q1,q2,u1,u2");
  CHECK(std::holds_alternative<Mass>(*starter(folder, {slide}).model.plant));
  CHECK(std::holds_alternative<TwoLinkArm>(*starter(folder, {arm}).model.plant));
  CHECK(std::holds_alternative<Custom>(*starter(folder, {slide}, "custom").model.plant));
  CHECK(starter(folder, {arm}, "pendulum").joints() == 1);
  CHECK_THROWS_WITH(starter(folder, {slide}, "two_link_arm"), Contains("columns that seem to be positions: 1"));
  const DiagnosisSpec several =
      starter(folder, {slide, write("b.csv", "t,x_mm,v_mm/s,force"), write("c.csv", "t,x_mm,v_mm/s,force")});
  CHECK(several.recordings.size() == 2);
  CHECK(several.held_out.front().name == "c.csv");
  const DiagnosisSpec milliseconds = starter(folder, {write("ms.csv", "t,q,u", 5.0)});
  CHECK(milliseconds.signals.time.column->scale == 1e-3);
  const DiagnosisSpec untimed = starter(folder, {write("untimed.csv", "q,u")});
  CHECK(untimed.signals.time.rate == 100.0);
}
