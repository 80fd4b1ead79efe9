#include "base/random.hpp"

namespace bayesctrl {

RandomStream random_stream(std::uint64_t seed, std::string_view key) {
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a, 64 bits
  for (const char letter : key) {
    hash ^= static_cast<unsigned char>(letter);
    hash *= 1099511628211ULL;
  }
  std::uint64_t mixed = seed + hash;  // SplitMix64 finaliser: neighbouring seeds give unrelated streams
  mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9ULL;
  mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebULL;
  return RandomStream(mixed ^ (mixed >> 31));
}

}  // namespace bayesctrl
