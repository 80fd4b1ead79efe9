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

namespace {

/// Two rods of 1 kg and 1 m that are let go at rest, 100 Hz, noise 5e-4; the second rubs, and is of `inertia` about its
/// joint. Columns t, q1, q2, u1, u2.
std::string let_go(double inertia, double q1, double q2, std::uint64_t seed) {
  constexpr double kGravity = 9.81, kDrag = 0.05, kDry = 0.1;
  RandomStream random(seed);
  std::ostringstream csv;
  csv.precision(9);
  csv << "t,q1,q2,u1,u2\n";
  std::array<double, 4> x{q1, q2, 0.0, 0.0};
  for (int k = 0; k < 800; ++k) {
    const double seen1 = x[0] + 5e-4 * draw_normal(random), seen2 = x[1] + 5e-4 * draw_normal(random);
    csv << 0.01 * k << "," << seen1 << "," << seen2 << ",0,0\n";
    for (int i = 0; i < 10; ++i) {
      x = testing::runge_kutta_step(x, 1e-3, [&](const std::array<double, 4>& y, double) {
        const auto [a, b, v, w] = y;
        const double c = 0.5 * std::cos(b), s = 0.5 * std::sin(b);
        const double m11 = 1.0 / 3.0 + inertia + 1.0 + 2.0 * c, m12 = inertia + c, m22 = inertia;
        const double hang = 0.5 * kGravity * std::sin(a + b);
        const double f1 = s * w * (2.0 * v + w) - 1.5 * kGravity * std::sin(a) - hang - kDrag * v;
        const double f2 = -s * v * v - hang - kDrag * w - kDry * std::tanh(w / 1e-3);
        const double det = m11 * m22 - m12 * m12;
        return std::array<double, 4>{v, w, (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det};
      });
    }
  }
  return csv.str();
}

/// With the model's inertia of 1/3.
Diagnosis let_go_diagnosed(double inertia) {
  const io_examples::Folder folder;
  write_file(folder.path() / "a.csv", let_go(inertia, 1.3, -0.5, 1));
  write_file(folder.path() / "b.csv", let_go(inertia, 1.6, 0.2, 2));
  write_file(folder.path() / "spec.yaml",
             "name: arm\nmodel: {plant: two_link_arm, parameters: {friction1: 0.05, friction2: 0.05}}\n"
             "signals: {time: t, position: [q1, q2], input: [u1, u2]}\nrecordings: [a.csv, b.csv]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

}  // namespace

TEST_CASE("A parameter with which nothing is left, where physics leaves much, is stated; else physics is",
          "[doubt][slow]") {
  const Diagnosis wrong = let_go_diagnosed(7.0 / 12.0);
  CHECK(wrong.verdict == Verdict::check_spec);
  REQUIRE_FALSE(wrong.suspicions.empty());
  CHECK(wrong.suspicions.front().what == "parameter");
  CHECK_THAT(wrong.suspicions.front().sentence, Catch::Contains("inertia2 = 0.583"));
  CHECK(wrong.suspicions.front().effects == std::vector<std::string>{"coulomb_friction@2"});
  const Diagnosis right = let_go_diagnosed(1.0 / 3.0);
  CHECK(right.verdict == Verdict::named);
  REQUIRE(right.explanation.effects.size() == 1);
  CHECK(right.explanation.effects[0].name == "coulomb_friction");
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
