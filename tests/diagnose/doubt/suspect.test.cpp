// Mistakes of a spec or a recording are found, whatever physics is hidden beside them; none is claimed where there is
// none. The machines are written out and integrated here, independently of the library.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/runge_kutta.hpp"

using namespace bayesctrl;

namespace {

constexpr double kPi = std::numbers::pi;

struct Row {
  double t, q, v, u;
};
using Rows = std::vector<Row>;

/// A pendulum (m 0.7, l 0.8, r 0.2) or a cart (m 1.7, r 1.1) driven by four sines, 100 Hz, noise 1e-3.
Rows recorded(bool pendulum, double dry, double spin, int number) {
  RandomStream random(static_cast<std::uint64_t>(100 + number));
  std::array<double, 8> sines{};
  for (double& s : sines) s = draw_uniform(random, 0.1, 1.4);
  const auto input = [&](double t) {
    double sum = spin > 0.0 ? 1.5 : 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      sum += (0.4 + 0.3 * double(i % 3)) * std::sin(2 * kPi * sines[i] * t + 4.0 * sines[i + 4]);
    return (pendulum ? 2.2 : 2.0) * sum;
  };
  Rows rows;
  std::array<double, 2> x{0.3 - 0.2 * number, spin};
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.01 * k, u = input(t);
    rows.push_back({t, x[0] + 1e-3 * draw_normal(random), x[1] + 3e-3 * draw_normal(random), u});
    for (int i = 0; i < 5; ++i) {
      x = testing::runge_kutta_step(x, 0.002, [&](const std::array<double, 2>& s, double) {
        const double rubs = dry * std::tanh(s[1] / 2e-3);
        const double a = pendulum ? (u - 0.2 * s[1] - rubs - 0.7 * 9.81 * 0.8 * std::sin(s[0])) / (0.7 * 0.64)
                                  : (u - 1.1 * s[1] - rubs) / 1.7;
        return std::array<double, 2>{s[1], a};
      });
    }
  }
  return rows;
}

struct Mistake {
  std::string what;
  std::function<void(Rows&)> recording = [](Rows&) {};
  std::map<std::string, double> parameters = {};
  double spin = 0.0;
};

std::function<void(Rows&)> each(std::function<void(Row&)> change) {
  return [change](Rows& rows) {
    for (Row& row : rows) change(row);
  };
}

/// The diagnosis of a machine whose spec or recordings hold a mistake.
Diagnosis diagnosed(bool pendulum, double dry, const Mistake& mistake) {
  const io_examples::Folder folder;
  for (int r = 0; r < 2; ++r) {
    Rows rows = recorded(pendulum, dry, mistake.spin, r);
    mistake.recording(rows);
    std::ostringstream csv;
    csv.precision(9);
    csv << "t,q,u\n";
    for (const Row& row : rows) csv << row.t << "," << row.q << "," << row.u << "\n";
    write_file(folder.path() / ("r" + std::to_string(r) + ".csv"), csv.str());
  }
  std::map<std::string, double> parameters{{"mass", pendulum ? 0.7 : 1.7}, {"friction", pendulum ? 0.2 : 1.1}};
  if (pendulum) parameters["length"] = 0.8;
  for (const auto& [name, value] : mistake.parameters) parameters[name] = value;
  std::ostringstream spec;
  spec << "name: doubted\nmodel:\n  plant: " << (pendulum ? "pendulum" : "mass") << "\n  parameters:\n";
  for (const auto& [name, value] : parameters) spec << "    " << name << ": " << value << "\n";
  spec << "signals: {time: t, position: q, input: u}\nrecordings: [r0.csv, r1.csv]\n";
  write_file(folder.path() / "spec.yaml", spec.str());
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

/// Mistakes that any machine may have.
std::vector<Mistake> common() {
  return {{"time_unit", each([](Row& r) { r.t *= 1e3; })},
          {"input_unit", each([](Row& r) { r.u *= 1e3; })},
          {"input_sign", each([](Row& r) { r.u = -r.u; })},
          {"position_sign", each([](Row& r) { r.q = -r.q; })},
          {"gear_ratio", each([](Row& r) { r.q *= 12.0; })},
          {"swapped_columns", each([](Row& r) { std::swap(r.q, r.u); })},
          {"velocity_for_position", each([](Row& r) { r.q = r.v; })},
          {"parameter_unit", each([](Row&) {}), {{"mass", 700.0}}},
          {"input_shift",
           [](Rows& rows) {
             for (std::size_t k = rows.size() - 1; k >= 5; --k) rows[k].u = rows[k - 5].u;
           }},
          {"spikes",
           [](Rows& rows) {
             for (const std::size_t k : {99U, 340U, 777U}) rows[k].q += k % 2 ? 0.6 : -0.8;
           }},
          {"stuck_sensor", [](Rows& rows) {
             for (const std::size_t from : {150U, 430U}) {
               for (std::size_t k = from + 1; k < from + 30; ++k) rows[k].q = rows[from].q;
             }
           }}};
}

std::vector<Mistake> of_pendulums() {
  std::vector<Mistake> list = common();
  list.push_back({"position_unit", each([](Row& r) { r.q *= 180.0 / kPi; })});
  list.push_back({"position_unit", each([](Row& r) { r.q *= kPi / 180.0; })});
  list.push_back({"zero_position", each([](Row& r) { r.q -= kPi; })});
  list.push_back({"zero_position", each([](Row& r) { r.q -= 0.5 * kPi; })});
  list.push_back({"parameter_unit", each([](Row&) {}), {{"length", 80.0}}});
  list.push_back({"wrapped_angle", each([](Row& r) { r.q = std::remainder(r.q, 2.0 * kPi); }), {}, 9.0});
  return list;
}

std::vector<Mistake> of_carts() {
  std::vector<Mistake> list = common();
  list[7].parameters = {{"mass", 1700.0}};
  list.push_back({"position_unit", each([](Row& r) { r.q *= 1e3; })});
  return list;
}

/// Whether a mistake is stated: first, or as one that nothing tells from the first.
bool stated(const Diagnosis& d, const std::string& what) {
  if (d.verdict != Verdict::check_spec) return false;
  for (const Suspicion& s : d.suspicions) {
    if (s.what == what && s.log_odds > d.suspicions.front().log_odds - 20.0) return true;
  }
  return false;
}

void check_stated(bool pendulum, double dry) {
  for (const Mistake& mistake : pendulum ? of_pendulums() : of_carts()) {
    INFO((pendulum ? "pendulum, " : "cart, ") << dry << ", " << mistake.what);
    const Diagnosis d = diagnosed(pendulum, dry, mistake);
    for (const Suspicion& s : d.suspicions) UNSCOPED_INFO(s.what << " " << s.log_odds << ": " << s.sentence);
    CHECK(stated(d, mistake.what));
    CHECK(d.explanation.effects.empty());
  }
}

}  // namespace

TEST_CASE("Mistakes of a spec or a recording of a pendulum are stated", "[doubt][slow]") { check_stated(true, 0.0); }

TEST_CASE("Mistakes of a spec or a recording of a pendulum that rubs are stated", "[doubt][slow]") {
  check_stated(true, 0.4);
}

TEST_CASE("Mistakes of a spec or a recording of a cart are stated", "[doubt][slow]") { check_stated(false, 0.0); }

TEST_CASE("Mistakes of a spec or a recording of a cart that rubs are stated", "[doubt][slow]") {
  check_stated(false, 0.5);
}

TEST_CASE("Without a mistake none is stated, and the friction is named", "[doubt]") {
  const bool pendulum = GENERATE(true, false);
  const Diagnosis clean = diagnosed(pendulum, 0.0, {});
  CHECK(clean.verdict == Verdict::nothing_missing);
  CHECK(clean.suspicions.empty());
  const Diagnosis rubs = diagnosed(pendulum, 0.4, {});
  CHECK(rubs.verdict == Verdict::named);
  CHECK(rubs.suspicions.empty());
}

TEST_CASE("A parameter of another value is suspected beside the physics that imitates it", "[doubt]") {
  const Diagnosis d = diagnosed(true, 0.0, {"parameter", each([](Row&) {}), {{"mass", 1.3}}});
  REQUIRE_FALSE(d.suspicions.empty());
  CHECK(d.suspicions.front().what == "parameter");
  CHECK_THAT(d.suspicions.front().sentence, Catch::Contains("mass = 0.7 instead of 1.3"));
}

TEST_CASE("Motion that has nothing to do with the input is no physics", "[doubt][slow]") {
  const bool pendulum = GENERATE(true, false);
  const double speed = GENERATE(0.8, 2.5);
  const Diagnosis turns = diagnosed(
      pendulum, 0.0, {"input_column", each([&](Row& r) { r.q = speed * r.t + std::remainder(1e4 * r.q, 2e-3); })});
  INFO((pendulum ? "pendulum" : "cart") << " at " << speed << ": " << turns.explanation.equation);
  CHECK(turns.verdict != Verdict::named);
  const Diagnosis swings = diagnosed(
      pendulum, 0.0,
      {"input_column", each([&](Row& r) { r.q = 0.7 * std::sin(speed * r.t) + std::remainder(1e4 * r.q, 2e-3); })});
  CHECK(swings.verdict != Verdict::named);
}
