#pragma once

#include <matio.h>

#include <memory>
#include <string>
#include <vector>

#include "diagnose/recording/data_table.hpp"
#include "diagnose/recording/spec.hpp"
#include "io/examples.hpp"

namespace bayesctrl::recording_examples {

using Names = std::vector<std::string>;
using Column = std::vector<double>;

inline DataTable parse(std::string_view text) { return parse_data_csv(text, "run.csv"); }
inline std::string parse_error(std::string_view text) {
  return io_examples::error_of<DataError>([&] { parse(text); });
}

inline Signal column(const std::string& name, const Location& where = {}) {
  Signal signal;
  signal.column = name;
  signal.where = where;
  return signal;
}

inline RecordingFile file_at(const std::filesystem::path& path) {
  RecordingFile file;
  file.file = path;
  return file;
}
/// Columns t, q and u.
inline Signals example_signals() {
  Signals signals;
  signals.time.column = column("t");
  signals.position = {PositionSignal{column("q")}};
  signals.input = {InputSignal{column("u", {"spec.yaml", 7, 10})}};
  return signals;
}

/// t,q,u with t = 0.1 k, q = k, u = -k.
inline std::string example_csv(int rows) {
  std::string text = "t,q,u\n";
  for (int k = 0; k < rows; ++k) {
    text += std::to_string(k / 10) + "." + std::to_string(k % 10) + "," + std::to_string(k) + ",-" + std::to_string(k) +
            "\n";
  }
  return text;
}

using Matlab = std::unique_ptr<mat_t, decltype(&Mat_Close)>;

inline matvar_t* row_of(const char* name, Column& values) {
  std::size_t dimensions[2] = {1, values.size()};
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dimensions, values.data(), 0);
}

inline void write_variable(const Matlab& file, matvar_t* variable) {
  Mat_VarWrite(file.get(), variable, MAT_COMPRESSION_NONE);
  Mat_VarFree(variable);
}

}  // namespace bayesctrl::recording_examples
