// The reader of specs and `--set`: any bytes are read or refused with a SpecError.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.hpp"
#include "io/node.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bayesctrl;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    Node node = parse_yaml(text, "fuzz.yaml");
    set_path(node, text.substr(0, text.find('\n')));
  } catch (const SpecError&) {
  }
  return 0;
}
