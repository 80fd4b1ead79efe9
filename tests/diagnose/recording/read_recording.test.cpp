#include "diagnose/recording/read_recording.hpp"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "diagnose/recording/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/fuzz.hpp"
#include "support/sanitized.hpp"
#include "support/text.hpp"

using namespace bayesctrl;
using namespace bayesctrl::recording_examples;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

RecordingFile between_times(double from, std::optional<double> to = {}) {
  RecordingFile file;
  file.from = from;
  file.to = to;
  return file;
}

Measured read_text(const std::string& text, const Signals& signals = example_signals(), RecordingFile file = {}) {
  const Folder folder;
  file.file = folder.path() / "run.csv";
  write_file(file.file, text);
  return read_recording(file, signals);
}

/// The message, without the folder.
std::string read_error(const std::string& text, const Signals& signals = example_signals(), RecordingFile file = {}) {
  const std::string message = error_of<DataError>([&] { read_text(text, signals, file); });
  const std::size_t name = message.find("run.csv");
  return name == std::string::npos ? message : message.substr(name);
}

}  // namespace

TEST_CASE("A signal may be given by the number of its column, unless a column is named so", "[diagnose]") {
  Signals signals = example_signals();
  const std::vector<std::string> columns{signals.position[0].column, signals.input[0].column};
  const Measured by_name = read_text(example_csv(20), signals);
  const DataTable table = parse(example_csv(20));
  const auto number = [&](const std::string& name) {
    return std::to_string(1 + std::find(table.names.begin(), table.names.end(), name) - table.names.begin());
  };
  signals.position[0].column = number(columns[0]);
  signals.input[0].column = number(columns[1]);
  const Measured by_number = read_text(example_csv(20), signals);
  CHECK(by_number.position == by_name.position);
  CHECK(by_number.input == by_name.input);
  for (const char* wrong : {"0", "99", "-1"}) {
    signals.position[0].column = wrong;
    CHECK_THROWS_AS(read_text(example_csv(20), signals), DataError);
  }
}

TEST_CASE("A temperature is read in degrees Celsius, of one joint or of all, where it is there", "[diagnose]") {
  std::string csv = "t,q,p,u,w,T,hot,none,even,odd\n";
  for (int k = 0; k < 20; ++k) {
    csv += std::to_string(2 + k) + ",0,0,0,0," + (k % 5 == 2 ? std::to_string(68 + 9 * k) : "") + "," +
           std::to_string(300 + k) + ",," + (k % 2 == 0 ? std::to_string(k + 2) + "," : "," + std::to_string(k + 2)) +
           "\n";
  }
  Signals signals = example_signals();
  signals.position.emplace_back(PositionSignal{column("p")});
  signals.input.emplace_back(InputSignal{column("w")});
  CHECK(read_text(csv, signals).temperature == nullptr);
  signals.temperature = {column("T")};
  signals.temperature[0].unit = "degF";
  const Measured one = read_text(csv, signals);  // (68 + 9 k) degrees Fahrenheit at every fifth second
  for (int joint = 0; joint < 2; ++joint) {
    for (const double t : {2.0, 4.5, 17.0}) CHECK(one.temperature->at(joint, t) == Approx(20.0 + 5.0 * t));
    CHECK(one.temperature->at(joint, 0.0) == Approx(30.0));
    CHECK(read_text(csv, signals, between_times(5.0, 13.5)).temperature->at(joint, 2.0) == Approx(55.0));
  }
  signals.temperature.push_back(column("hot"));
  signals.temperature[1].unit = "K";
  const Measured both = read_text(csv, signals);
  CHECK(both.temperature->at(0, 7.0) == Approx(55.0));
  CHECK(both.temperature->at(1, 7.0) == Approx(307.0 - 273.15));

  for (const char* name : {"odd", "even"}) {  // joints logged in turn
    signals.temperature[name[0] == 'o'] = column(name);
    signals.temperature[name[0] == 'o'].unit = "degC";
  }
  CHECK(read_text(csv, signals).temperature->at(0, 8.5) == Approx(10.5));
  CHECK(read_text(csv, signals).temperature->at(1, 8.5) == Approx(10.5));

  signals.temperature = {column("cold")};
  CHECK_THAT(read_error(csv, signals), Catch::Contains("no column 'cold'"));
  signals.temperature = {column("none")};
  CHECK_THAT(read_error(csv, signals), Catch::Contains("column 'none' has no number in it"));
  CHECK_THAT(read_error(csv, signals, between_times(4.0)), Catch::Contains("no number between from and to"));
}

TEST_CASE("A noisy temperature is averaged over a second, and keeps its trend up to its ends", "[diagnose]") {
  constexpr int kRows = 2000;
  std::string csv = "t,q,u,T\n";
  for (int k = 0; k < kRows; ++k) {
    const double t = 0.01 * k;
    csv += std::to_string(t) + ",0,0," + std::to_string(30.0 + 2.0 * t + (k % 2 == 0 ? 0.5 : -0.5)) + "\n";
  }
  Signals signals = example_signals();
  signals.temperature = {column("T")};
  const RecordedTemperature found = read_text(csv, signals).temperature;
  for (int k = 0; k < kRows; ++k) {
    const double t = 0.01 * k, error = found->at(0, t) - 30.0 - 2.0 * t;
    const int from_end = std::min(k, kRows - 1 - k);
    CHECK(std::abs(error) < (from_end < 100 ? 2.0 / (2 * std::min(from_end, 50) + 1) : 0.011));
  }
}

TEST_CASE("A recording of millions of rows is read in the memory of its pieces", "[diagnose][slow]") {
  const Folder folder;
  const int rows = 8'000'000;
  {
    std::ofstream csv(folder.path() / "run.csv");
    csv << "a,q,u\n";
    std::string line;
    for (int k = 0; k < rows; ++k) {
      line = "0," + std::to_string(k % 1000) + "," + std::to_string(k) + "\n";
      csv << line;
    }
  }
  Signals signals = example_signals();
  signals.time.column.reset();
  signals.time.rate = 1000.0;
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const Measured measured = read_recording(file_at(folder.path() / "run.csv"), signals);
  getrusage(RUSAGE_SELF, &after);
  if (!kSanitized) CHECK(after.ru_maxrss - before.ru_maxrss < 550'000);  // kB
  CHECK(measured.samples() + measured.left_out == static_cast<std::size_t>(rows));
  CHECK(measured.left_out > 0);
  CHECK(stretches(measured, 0).size() >= 16);
  CHECK(measured.time.back() > 0.9 * rows / signals.time.rate);
  for (const std::size_t i : {std::size_t{0}, measured.samples() / 2, measured.samples() - 1}) {
    const double row = std::round(measured.time[i] * signals.time.rate);
    CHECK(measured.input(static_cast<Eigen::Index>(i), 0) == row);
    CHECK(measured.position(static_cast<Eigen::Index>(i), 0) == std::fmod(row, 1000.0));
  }
}

TEST_CASE("A recording has its signals in SI units, with time from its first sample", "[diagnose]") {
  Signals signals = example_signals();
  signals.position[0].scale = 0.5;
  signals.position[0].offset = 3.0;
  signals.input[0].scale = -2.0;
  RecordingFile file;
  file.name = "run";
  const Measured found = read_text(example_csv(20), signals, file);
  REQUIRE(found.samples() == 20);
  CHECK(found.name == "run");
  CHECK(found.start == 0.0);
  CHECK_FALSE(found.linear_hold);
  for (int k = 0; k < 20; ++k) {
    CHECK(found.time[static_cast<std::size_t>(k)] == Approx(0.1 * k));
    CHECK(found.position(k, 0) == 0.5 * k + 3.0);
    CHECK(found.input(k, 0) == 2.0 * k);
  }
  signals.input[0].hold = Hold::linear;
  CHECK(read_text(example_csv(20), signals).linear_hold);
}

TEST_CASE("Columns may stand in any order and serve several joints", "[diagnose]") {
  Signals signals = example_signals();
  signals.position = {PositionSignal{column("u")}, PositionSignal{column("q")}};
  signals.input = {InputSignal{column("q")}, InputSignal{column("u")}};
  const Measured found = read_text(example_csv(10), signals);
  CHECK(found.position == found.input.rowwise().reverse());
  CHECK(found.position(3, 0) == -3.0);
}

TEST_CASE("Without a column of time the samples come at the stated rate", "[diagnose]") {
  Signals signals = example_signals();
  signals.time.column.reset();
  signals.time.rate = 250.0;
  const Measured found = read_text(example_csv(20), signals, between_times(0.02));
  REQUIRE(found.samples() == 15);
  CHECK(found.start == 0.02);
  for (std::size_t k = 0; k < 15; ++k) CHECK(found.time[k] == Approx(0.004 * static_cast<double>(k)).margin(1e-12));
  CHECK(found.position(0, 0) == 5.0);
}

TEST_CASE("From and to cut a recording at its own time stamps, both ends included", "[diagnose]") {
  const Measured found = read_text(example_csv(30), example_signals(), between_times(0.5, 1.5));
  REQUIRE(found.samples() == 11);
  CHECK(found.start == 0.5);
  CHECK(found.time.front() == 0.0);
  CHECK(found.time.back() == Approx(1.0));
  CHECK(found.position(0, 0) == 5.0);
  CHECK(found.position(10, 0) == 15.0);
  CHECK_THAT(read_error(example_csv(30), example_signals(), between_times(0.5, 0.9)),
             Catch::StartsWith("run.csv: only 5 samples between from and to"));
}

TEST_CASE("Of rows with the same time stamp the first is kept", "[diagnose]") {
  const Measured found = read_text(replaced(example_csv(10), "\n0.4,4", "\n0.3,99,99\n0.3,98,98\n0.4,4"));
  REQUIRE(found.samples() == 10);
  for (int k = 0; k < 10; ++k) CHECK(found.position(k, 0) == k);
}

TEST_CASE("Samples that stand alone before or behind all others are no part of a recording", "[diagnose]") {
  const std::string header = "t,q,u\n", rows = example_csv(20).substr(header.size());
  const Measured whole = read_text(header + rows);
  for (const bool before : {true, false}) {
    for (const double apart : {20.0, 1.7e9}) {
      const double stray = before ? -apart : apart;
      const std::string row = format(stray, 12) + ",7,7\n";
      const Measured found = read_text(header + (before ? row + rows : rows + row));
      INFO(row);
      CHECK(found.start == whole.start);
      CHECK(found.time == whole.time);
      CHECK(found.position == whole.position);
      CHECK(found.input == whole.input);
    }
  }
  CHECK(read_text(header + "-0.1,7,7\n" + rows).samples() == 21);
}

TEST_CASE("A clock that was set amid a recording is refused at its line", "[diagnose]") {
  std::string text = example_csv(10);
  for (int k = 0; k < 10; ++k) text += format(1.7e9 + 0.1 * k, 12) + ",1,1\n";
  CHECK(read_error(text) ==
        "run.csv:12: time jumps from 0.9 to 1700000000 s: the clock was set; choose what lies before or behind with "
        "from and to");
  std::string fast = "t,q,u\n";  // nanoseconds, unit not told: no pause is as long as the recording
  for (int k = 0; k < 40; ++k) fast += format(1e7 * k + (k < 20 ? 0.0 : 2e8), 12) + ",1,1\n";
  CHECK(read_text(fast).samples() == 40);
  CHECK(read_text(text, example_signals(), between_times(1.0)).samples() == 10);
  CHECK(read_text(text, example_signals(), between_times(0.0, 1.0)).samples() == 10);
}

TEST_CASE("A recording that cannot be used is refused at its line", "[diagnose]") {
  const std::string text = example_csv(10);
  CHECK(read_error(text) == "nothing thrown");
  for (const std::string cell : {"NaN", "nan", "inf", "-Inf", "", "off", "0x10", "1.2.3", "1e999", "--1", "1 2"}) {
    INFO(cell);
    CHECK_THAT(read_error(replaced(text, "0.4,4,-4", "0.4," + cell + ",-4")),
               Catch::StartsWith("run.csv:6: column 'q'"));
    CHECK_THAT(read_error(replaced(text, "0.4,4,-4", "0.4,4," + cell)), Catch::StartsWith("run.csv:6: column 'u'"));
    CHECK_THAT(read_error(replaced(text, "0.4,4,-4", cell + ",4,-4")), Catch::StartsWith("run.csv:6: column 't'"));
  }
  CHECK_THAT(read_error(replaced(text, "0.4,4", "0.25,4")),
             Catch::StartsWith("run.csv:6: time runs backwards, from 0.3 to 0.25 s"));
  CHECK(read_error(example_csv(8)) == "nothing thrown");
  CHECK(read_error(example_csv(7)) == "run.csv: only 7 samples: too short a recording");
  CHECK_THAT(read_error(""), Catch::StartsWith("run.csv: the file is empty"));
}

TEST_CASE("What a column holds that no signal names does not matter", "[diagnose]") {
  std::string text = "note,t,q,u\n";
  for (int k = 0; k < 10; ++k) text += (k % 2 == 0 ? "NaN," : "on,") + std::to_string(k) + ",1,2\n";
  CHECK(read_text(text).samples() == 10);
}

TEST_CASE("Rows without a number may be cut out with from and to", "[diagnose]") {
  const std::string text = replaced(example_csv(30), "0.1,1,", "0.1,NaN,");
  CHECK(read_error(text, example_signals(), between_times(0.5)) == "nothing thrown");
}

TEST_CASE("A number that scaling makes infinite is refused", "[diagnose]") {
  Signals signals = example_signals();
  signals.position[0].scale = 1e200;
  CHECK(read_error(replaced(example_csv(10), "0.4,4", "0.4,1e200"), signals) != "nothing thrown");
}

TEST_CASE("A column that is missing is named with the nearest and with where the spec names it", "[diagnose]") {
  Signals signals = example_signals();
  signals.input[0].column = "torqe";
  const std::string message = read_error(replaced(example_csv(10), "t,q,u", "t,q,torque"), signals);
  CHECK(message == "run.csv: no column 'torqe' (named at spec.yaml:7:10): did you mean 'torque'?");
  CHECK_THAT(read_error(example_csv(10), signals), Catch::Contains("allowed: t, q, u"));
}

TEST_CASE("A file that does not exist is the machine's error", "[diagnose]") {
  CHECK_THROWS_AS(read_recording(file_at("/nowhere/run.csv"), example_signals()), IoError);
  CHECK_THROWS_AS(read_recording(file_at("/nowhere/run.mat"), example_signals()), Error);
}

TEST_CASE("Any bytes are either a recording or refused in one line", "[diagnose]") {
  constexpr std::string_view kBytes = "tqu,,,;;\t\n\n\n\r\"# 0123456789.-+eEnainf\xEF\xBB\xBF";
  RandomStream stream(4);
  const Folder folder;
  const RecordingFile file = file_at(folder.path() / "run.csv");
  int parsed = 0, taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = i % 2 == 0 ? random_text(stream, kBytes) : mutated(example_csv(10), stream, kBytes);
    DataTable table;
    if (!accepted<Error>(text, [&] { table = parse(text); })) continue;
    ++parsed;
    REQUIRE(table.names.size() == table.columns.size());
    for (const Column& column : table.columns) REQUIRE(column.size() == table.lines.size());
    if (i % 20 != 1) continue;
    write_file(file.file, text);
    Measured found;
    if (!accepted<Error>(text, [&] { found = read_recording(file, example_signals()); })) continue;
    ++taken;
    REQUIRE(std::is_sorted(found.time.begin(), found.time.end(), std::less_equal<>{}));
    REQUIRE((found.position.allFinite() && found.input.allFinite()));
  }
  CHECK(parsed > 1000);
  CHECK(taken > 20);
}

TEST_CASE("The signals of a simulation must be as long as its time", "[diagnose]") {
  const Folder folder;
  RecordingFile file = file_at(folder.path() / "run.csv");
  file.simulation = folder.path() / "simulated.mat";
  write_file(file.file, example_csv(30));
  Column t, q{1, 2, 3};
  for (int k = 0; k < 30; ++k) t.push_back(0.1 * k);
  {
    const Matlab matlab(Mat_CreateVer(file.simulation.c_str(), nullptr, MAT_FT_MAT5), &Mat_Close);
    write_variable(matlab, row_of("t", t));
    write_variable(matlab, row_of("q", q));
  }
  const Measured measured = read_recording(file, example_signals());
  CHECK_THROWS_AS(read_simulation(file, example_signals(), measured), DataError);
}

TEST_CASE("A simulation is interpolated at the recording's times", "[diagnose]") {
  const Folder folder;
  RecordingFile file = file_at(folder.path() / "run.csv");
  file.from = 0.35;
  file.simulation = folder.path() / "simulated.csv";
  write_file(file.file, example_csv(30));
  write_file(file.simulation, "q,t\n0,0\n5,1\n5,2\n20,3\n");
  const Measured measured = read_recording(file, example_signals());
  const Eigen::MatrixXd found = read_simulation(file, example_signals(), measured);
  REQUIRE(found.rows() == 26);
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    const double t = 0.1 * (static_cast<double>(k) + 4.0);
    CHECK(found(k, 0) == Approx(t < 1.0 ? 5.0 * t : t < 2.0 ? 5.0 : 15.0 * t - 25.0).margin(1e-9));
  }
  write_file(file.simulation, "q,t\n0,0\n5,0.5\n5,1\n20,1.5\n");
  CHECK_THAT(error_of<DataError>([&] { read_simulation(file, example_signals(), measured); }),
             Catch::Contains("the simulation covers 0 to 1.5 s, the recording 0.4 to 2.9 s"));
}

TEST_CASE("Every unit is converted to SI by name, in whatever notation", "[diagnose]") {
  const auto in_si = [](const std::string& unit, double value) {
    Signal signal = column("q");
    signal.unit = unit;
    CHECK(signal.problem().empty());
    return signal.to_si()(value);
  };
  const double pi = std::acos(-1.0);
  for (const char* degrees : {"deg", "degrees", "\xC2\xB0", "\xB0"}) CHECK(in_si(degrees, 180.0) == Approx(pi));
  for (const char* torque : {"mN m", "mNm", "mN\xC2\xB7m"}) CHECK(in_si(torque, 250.0) == Approx(0.25));
  CHECK(in_si("rpm", 60.0) == Approx(2.0 * pi));
  CHECK(in_si("\xC2\xB5s", 5.0) == Approx(5e-6));
  CHECK(in_si("mm", 12.0) == Approx(0.012));
  CHECK(in_si("V", 3.0) == 3.0);
  CHECK(in_si("", 3.0) == 3.0);
  Signal signal = column("q");
  signal.scale = 2.0;
  signal.offset = 1.0;
  signal.unit = "mm";
  CHECK(signal.to_si()(4.0) == Approx(9e-3));
  for (const char* unknown : {"furlong", "MN", "Deg/s", "rad^2"}) {
    signal.unit = unknown;
    CHECK_THAT(signal.problem(), Catch::Contains("unit '" + std::string(unknown) + "' is not known; known are rad, "));
  }
}

TEST_CASE("Turns that start again are taken out where a spec says so", "[diagnose]") {
  const Folder folder;
  const RecordingFile file = file_at(folder.path() / "run.csv");
  std::string text = "t,q,u\n";
  const auto turned = [](int k) { return 400.0 * std::sin(0.05 * k); };  // degrees
  for (int k = 0; k < 200; ++k) {
    text += std::to_string(0.1 * k) + "," + std::to_string(std::remainder(turned(k), 360.0)) + ",0\n";
  }
  write_file(file.file, text);
  Signals signals = example_signals();
  signals.position.front().unit = "deg";
  CHECK(read_recording(file, signals).position.cwiseAbs().maxCoeff() < 3.15);
  signals.position.front().unwrap = true;
  const Measured measured = read_recording(file, signals);
  for (int k = 0; k < 200; ++k)
    CHECK(measured.position(k, 0) == Approx(turned(k) * std::acos(-1.0) / 180.0).margin(1e-6));
}
