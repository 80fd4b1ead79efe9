#include "control/monitor.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

/// Share of 2000 streams of N(0, scale^2) in which an alarm is raised within `length` surprises.
double share_of_alarms(double rate, double scale, int length) {
  RandomStream random = random_stream(5, "surprises");
  int alarms = 0;
  for (int stream = 0; stream < 2000; ++stream) {
    SurpriseTest test(rate);
    bool raised = false;
    for (int k = 0; k < length && !raised; ++k) raised = test(scale * draw_normal(random));
    alarms += raised ? 1 : 0;
  }
  return alarms / 2000.0;
}

}  // namespace

TEST_CASE("While surprises are those of the belief, an alarm is ever raised with at most the stated probability",
          "[control]") {
  for (const double rate : {0.01, 0.05, 0.2}) {
    INFO(rate);
    CHECK(share_of_alarms(rate, 1.0, 400) <= rate + 3.0 * std::sqrt(rate * (1.0 - rate) / 2000.0));
  }
}

TEST_CASE("An over-confident belief is found, the sooner the more confident it is", "[control]") {
  CHECK(share_of_alarms(0.01, 2.0, 40) > 0.99);
  CHECK(share_of_alarms(0.01, 5.0, 8) > 0.97);
  CHECK(share_of_alarms(0.01, 50.0, 3) > 0.97);
  CHECK(share_of_alarms(0.01, 0.5, 400) == 0.0);  // and one that is too modest never is
}

TEST_CASE("One surprise alone, however large, raises no alarm; two do, and then the test begins anew", "[control]") {
  SurpriseTest test(0.01);
  CHECK_FALSE(test(1e6));
  CHECK(test(1e6));
  CHECK(test.log_evidence() == Approx(0.0).margin(1e-12));
  CHECK_FALSE(test(1e6));
  CHECK_FALSE(test(std::nan("")));  // no surprise, and no end to the test
  CHECK(test(1e6));
}
