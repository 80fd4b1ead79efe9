#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cstdint>
#include <string_view>

namespace bayesctrl {

/// A stream of random numbers. Its sequence is fixed by the standard and by Boost, not by the platform.
using RandomStream = boost::random::mt19937_64;

/// The stream of one run: it follows from the study's seed and the run's key alone, never from the order of the runs.
RandomStream random_stream(std::uint64_t seed, std::string_view key);

inline double draw_normal(RandomStream& stream) { return boost::random::normal_distribution<double>()(stream); }

inline double draw_uniform(RandomStream& stream, double low, double high) {
  return low < high ? boost::random::uniform_real_distribution<double>(low, high)(stream) : low;
}

}  // namespace bayesctrl
