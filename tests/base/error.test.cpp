#include "base/error.hpp"

#include <catch2/catch.hpp>

using namespace bayesctrl;

namespace {
const std::vector<std::string_view> kKeys{"output_scale", "length_scales", "shape"};
}

TEST_CASE("A misspelt name is answered by the nearest allowed one", "[base]") {
  CHECK(suggestion("lenght_scales", kKeys) == "did you mean 'length_scales'?");
  CHECK(suggestion("outputscale", kKeys) == "did you mean 'output_scale'?");
  CHECK(suggestion("shap", kKeys) == "did you mean 'shape'?");
  CHECK(suggestion("hsape", kKeys) == "did you mean 'shape'?");
}

TEST_CASE("A name unlike every allowed one is answered by the list of them in order", "[base]") {
  CHECK(suggestion("colour", kKeys) == "allowed: output_scale, length_scales, shape");
  CHECK(suggestion("", kKeys) == "allowed: output_scale, length_scales, shape");
  CHECK(suggestion("xy", {"ab"}) == "allowed: ab");
  CHECK(suggestion("x", {}) == "allowed:");
}

TEST_CASE("A name counts as meant up to an edit for each three letters, and always one", "[base]") {
  CHECK(nearest("abcdef", {"abcdxy"}) == "abcdxy");  // two replacements
  CHECK(nearest("abcdef", {"abcxyz"}).empty());      // three
  CHECK(nearest("ab", {"ax"}) == "ax");
  CHECK(nearest("ab", {"xy"}).empty());
  CHECK(nearest("abdc", {"abcd"}) == "abcd");     // neighbours swapped is one edit
  CHECK(nearest("abc", {"ab", "abcd"}) == "ab");  // equally near: the first
  CHECK(nearest("abc", {"abx", "abc"}) == "abc");
}

TEST_CASE("A name of absurd length is not compared", "[base]") {
  const std::string absurd(100'000, 'a');
  CHECK(nearest(absurd, {absurd}).empty());
  const std::string longest(100, 'a');
  CHECK(nearest(longest, {longest}) == longest);
}

TEST_CASE("A location is written as file, line and column as far as they are known", "[base]") {
  CHECK(to_string(Location{"exp1.yaml", 14, 5}) == "exp1.yaml:14:5");
  CHECK(to_string(Location{"exp1.yaml", 14, 0}) == "exp1.yaml:14");
  CHECK(to_string(Location{"exp1.yaml", 0, 5}) == "exp1.yaml");
}

TEST_CASE("Each error carries its place and the exit code of who is at fault", "[base]") {
  const SpecError spec({"exp1.yaml", 14, 5}, "squared_exponential has no 'lenght_scale', " +
                                                 suggestion("lenght_scale", {"length_scale", "output_scale"}));
  CHECK(std::string(spec.what()) ==
        "exp1.yaml:14:5: squared_exponential has no 'lenght_scale', did you mean 'length_scale'?");
  CHECK(spec.code() == ExitCode::bad_input);
  CHECK(std::string(DataError({"run.csv", 3, 0}, "no column 'q'").what()) == "run.csv:3: no column 'q'");
  CHECK(DataError({}, "").code() == ExitCode::bad_input);
  CHECK(NumericalError("").code() == ExitCode::numerical);
  CHECK(IoError("").code() == ExitCode::io);
}
