#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace bayesctrl {

/// Process exit codes, the same for every subcommand.
enum class ExitCode : int {
  ok = 0,
  check_failed = 1,
  usage = 2,
  bad_input = 3,
  numerical = 4,
  partial = 5,
  io = 6,
  interrupted = 130,
};

/// Where something stands in a user's file. Line and column count from 1; 0 means "the file as a whole".
struct Location {
  std::string file;
  int line = 0;
  int column = 0;

  bool operator==(const Location&) const = default;
};

/// "file:line:column", without the parts that are unknown.
std::string to_string(const Location& where);

/// Base of everything that this program throws on purpose.
class Error : public std::runtime_error {
 public:
  Error(const std::string& what, ExitCode code) : std::runtime_error(what), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// A spec that cannot be accepted; the text is "file:line:column: what, what is allowed, did you mean".
class SpecError : public Error {
 public:
  SpecError(const Location& where, const std::string& what)
      : Error(to_string(where) + ": " + what, ExitCode::bad_input) {}
};

/// A data file (CSV, MAT) that cannot be accepted, with the same form of text.
class DataError : public Error {
 public:
  DataError(const Location& where, const std::string& what)
      : Error(to_string(where) + ": " + what, ExitCode::bad_input) {}
};

/// The numbers failed: not positive definite, not finite, diverged. Caught per run and reported as that run's row.
class NumericalError : public Error {
 public:
  explicit NumericalError(const std::string& what) : Error(what, ExitCode::numerical) {}
};

/// The machine failed: an unreadable file, a full disk, a read-only folder.
class IoError : public Error {
 public:
  explicit IoError(const std::string& what) : Error(what, ExitCode::io) {}
};

/// The nearest of `allowed` by edit distance, or empty when nothing is near enough to be meant.
std::string_view nearest(std::string_view given, const std::vector<std::string_view>& allowed);

/// "'given' ..., did you mean 'x'?" or, without a near name, "allowed: a, b, c".
std::string suggestion(std::string_view given, const std::vector<std::string_view>& allowed);

}  // namespace bayesctrl
