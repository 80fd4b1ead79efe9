// The reader of tables: any bytes are refused with a DataError, or read to a table that is written and read the same.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "base/error.hpp"
#include "io/table.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bayesctrl;
  try {
    const std::string csv = to_csv(parse_csv({reinterpret_cast<const char*>(data), size}, "fuzz.csv"));
    if (to_csv(parse_csv(csv, "again.csv")) != csv) std::abort();
  } catch (const DataError&) {
  }
  return 0;
}
