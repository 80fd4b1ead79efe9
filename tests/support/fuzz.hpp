#pragma once

// Texts for readers that must take or refuse anything.

#include <catch2/catch.hpp>
#include <string>
#include <string_view>

#include "base/random.hpp"

namespace bayesctrl::testing {

inline constexpr std::string_view kYamlBytes = "[]{}:,-?&*!|>'\"%@`#\n\n  \t\r\\~<=.019aeu\xc3\xbc\xef\xbb\xbf";

/// Bytes of `special` come more often than others.
inline char random_byte(RandomStream& stream, std::string_view special = kYamlBytes) {
  return stream() % 4 == 0 ? static_cast<char>(stream() % 256) : special[stream() % special.size()];
}

inline std::string random_text(RandomStream& stream, std::string_view special = kYamlBytes) {
  std::string text(stream() % 60, ' ');
  for (char& c : text) c = random_byte(stream, special);
  return text;
}

inline std::string mutated(std::string text, RandomStream& stream, std::string_view special = kYamlBytes) {
  for (std::uint64_t changes = 1 + stream() % 4; changes > 0; --changes) {
    const std::size_t at = stream() % text.size();
    switch (stream() % 4) {
      case 0:
        text[at] = random_byte(stream, special);
        break;
      case 1:
        text.insert(at, 1, random_byte(stream, special));
        break;
      case 2:
        text.erase(at, 1 + stream() % 10);
        break;
      default:
        text.insert(stream() % text.size(), text.substr(at, stream() % 30));
    }
    if (text.empty()) text = "x";
  }
  return text;
}

/// True if `f` returns, false if it throws E; anything else fails the test.
template <class E>
bool accepted(const std::string& text, auto&& f) {
  try {
    f();
    return true;
  } catch (const E& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos)
      FAIL("a message of two lines: " << error.what());
    return false;
  } catch (const std::exception& error) {
    FAIL("threw another error, " << error.what() << ", for:\n" << text);
    return false;
  }
}

}  // namespace bayesctrl::testing
