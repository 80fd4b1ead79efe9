#include "diagnose/motion/decimate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "diagnose/motion/forcing.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/table.hpp"
#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"

using namespace bayesctrl;

namespace {

const Plant kLooseArm = TwoLinkArm{.mass1 = 2.0,
                                   .mass2 = 1.5,
                                   .length1 = 0.8,
                                   .length2 = 0.6,
                                   .com1 = 0.4,
                                   .com2 = 0.3,
                                   .inertia1 = 0.5,
                                   .inertia2 = 0.2,
                                   .friction1 = 0.3,
                                   .friction2 = 0.1};
const Plant kLoosePendulum = Pendulum{.length = 0.8, .friction = 0.1, .mass = 0.6};

/// A plant under sums of sines, sampled at `rate`, exact positions; `steps`: their signs alone, which change at any
/// time.
Measured recorded(const Plant& plant, double rate, double seconds, std::uint64_t seed, bool steps = false) {
  const auto n = joints(plant);
  const auto samples = static_cast<Eigen::Index>(seconds * rate);
  RandomStream random(seed);
  Measured data{"r", {}, {}, Eigen::MatrixXd::Zero(samples, n), 0.0, false};
  for (Eigen::Index k = 0; k < samples; ++k) data.time.push_back(static_cast<double>(k) / rate);
  for (int j = 0; j < n; ++j) {
    const double strength = n == 1 ? 3.0 : j == 0 ? 6.0 : 2.0;
    for (const double frequency : {0.3, 0.7, 1.3, 2.1}) {
      const double amplitude = strength * draw_normal(random), phase = draw_uniform(random, 0.0, 6.28);
      for (Eigen::Index k = 0; k < samples; ++k) {
        data.input(k, j) +=
            amplitude * std::sin(2.0 * M_PI * frequency * data.time[static_cast<std::size_t>(k)] + phase);
      }
    }
    if (steps) data.input.col(j) = strength * data.input.col(j).array().sign();
  }
  const Machine machine(plant, {});
  StateVector start = StateVector::Zero(2 * n);
  for (int j = 0; j < n; ++j) start[j] = draw_uniform(random, -0.5, 0.5);
  data.position = machine.run(start, data.time, machine.drives(data.time, data.input), 0,
                              static_cast<std::size_t>(samples) - 1, 1e-3, HiddenStates{{}, JointVector::Zero(n)});
  return data;
}

/// The same machine from the same start under the inputs of `data`.
Eigen::MatrixXd simulated(const Plant& plant, const Measured& data, const StateVector& start) {
  const Machine machine(plant, {});
  return machine.run(start, data.time, machine.drives(data.time, data.input), 0, data.samples() - 1, 1e-3,
                     HiddenStates{{}, JointVector::Zero(joints(plant))});
}

std::size_t thinned_samples(const Plant& plant, const Measured& data, double noise, double rate = 200.0) {
  return decimated(plant, {data}, Eigen::VectorXd::Constant(joints(plant), noise), rate).front().samples();
}

}  // namespace

TEST_CASE("Recordings that are thinned out simulate as before, beside the noise", "[diagnose][decimate]") {
  for (const Plant& plant : {kLoosePendulum, kLooseArm}) {
    for (const double rate : {500.0, 1000.0, 2000.0}) {
      for (const double noise : {1e-2, 1e-3, 1e-4}) {
        const Measured whole = recorded(plant, rate, 4.0, 3);
        const Measured less = decimated(plant, {whole}, Eigen::VectorXd::Constant(joints(plant), noise), 200.0).front();
        CAPTURE(rate, noise, less.samples());
        CHECK(less.samples() < whole.samples() / 2 + 2);  // these inputs are smooth
        // Within the first window, from the true start: nothing is projected out here, hence the factor.
        StateVector start(2 * joints(plant));
        RandomStream random(0);
        start << whole.position.row(0).transpose(), JointVector::Zero(joints(plant));
        const Eigen::MatrixXd q = simulated(plant, less, start);
        double squares = 0.0;
        for (Eigen::Index k = 0; k < q.rows() && less.time[static_cast<std::size_t>(k)] < kSettings.motion.segment;
             ++k) {
          squares += ((q.row(k) - less.position.row(k)) / noise).squaredNorm();
        }
        CHECK(squares < 20.0 * kSettings.motion.thinning);
      }
    }
  }
}

TEST_CASE("How far a recording is thinned out depends on what that does beside the noise", "[diagnose][decimate]") {
  const Measured smooth = recorded(kLooseArm, 2000.0, 4.0, 5), steps = recorded(kLooseArm, 2000.0, 4.0, 5, true);
  CHECK(thinned_samples(kLooseArm, smooth, 1e-2) == 800);
  CHECK(thinned_samples(kLooseArm, steps, 1.0) == 800);
  CHECK(thinned_samples(kLooseArm, steps, 1e-6) == steps.samples());
  CHECK(thinned_samples(kLooseArm, smooth, 1e-2, 1500.0) == smooth.samples());  // less than twice the rate
  std::size_t before = 0;
  for (const double noise : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const std::size_t samples = thinned_samples(kLooseArm, steps, noise);
    CHECK(samples >= before);
    before = samples;
  }
}

TEST_CASE("Thinned inputs keep the impulse and stay within the range of what they replace", "[diagnose][decimate]") {
  for (const bool steps : {false, true}) {
    const Measured whole = recorded(kLoosePendulum, 1000.0, 3.0, 7, steps);
    const Measured less = decimated(kLoosePendulum, {whole}, Eigen::VectorXd::Constant(1, 1e-3), 200.0).front();
    REQUIRE(less.samples() < whole.samples());
    const double slack = 1e-3 * (whole.input.maxCoeff() - whole.input.minCoeff());
    CHECK(less.input.maxCoeff() <= whole.input.maxCoeff() + slack);
    CHECK(less.input.minCoeff() >= whole.input.minCoeff() - slack);
    CHECK(less.input.mean() == Approx(whole.input.mean()).margin(2e-2));
  }
  Measured straight = recorded(kLoosePendulum, 1000.0, 3.0, 7);
  straight.linear_hold = true;
  const Measured less = decimated(kLoosePendulum, {straight}, Eigen::VectorXd::Constant(1, 1e-2), 200.0).front();
  for (Eigen::Index k = 0; k < less.input.rows(); ++k) CHECK(less.input(k, 0) == straight.input(5 * k, 0));
}

TEST_CASE("Maps and loads act on what was recorded, not on its mean over the samples that are left out",
          "[diagnose][decimate]") {
  // A noisy controller: between two samples that stay its input is on both sides of every edge.
  for (const EffectForm& map :
       {EffectForm{InputSaturation{2.0}}, EffectForm{InputDeadZone{1.5}}, EffectForm{Backlash{2.0}},
        EffectForm{InputGain{1.3}}, EffectForm{LoadDependentFriction{0.3}},
        EffectForm{LoadStribeckFriction{0.2, 0.35, 0.3}}}) {
    Measured whole = recorded(kLoosePendulum, 2000.0, 4.0, 3);
    RandomStream random(9);
    for (double& u : whole.input.reshaped()) u += 2.0 * draw_normal(random);
    const Machine machine(kLoosePendulum, {{map, 0}});
    const StateVector start = StateVector::Zero(2);
    const auto run = [&](const Measured& m, const FineInput* fine) {
      return machine.run(start, m.time, machine.drives(m.time, m.input, fine), 0, m.samples() - 1, 1e-3);
    };
    const double noise = 1e-3;
    const Measured less = decimated(kLoosePendulum, {whole}, Eigen::VectorXd::Constant(1, noise), 200.0).front();
    REQUIRE(less.samples() < whole.samples() / 4);
    REQUIRE(less.fine != nullptr);
    CHECK(less.fine->held(less.fine->input.col(0), less.input.rows()).isApprox(less.input.col(0)));
    const Eigen::MatrixXd exact = run(whole, nullptr);
    const auto apart = [&](const Eigen::MatrixXd& q) {
      double most = 0.0;
      for (std::size_t k = 0, at = 0; k < less.samples(); ++k) {
        while (whole.time[at] < less.time[k]) ++at;
        most = std::max(most, std::abs(q(static_cast<Eigen::Index>(k), 0) - exact(static_cast<Eigen::Index>(at), 0)));
      }
      return most;
    };
    INFO(map.name());
    CHECK(apart(run(less, less.fine.get())) < 3.0 * noise);
    if (!map.roles().gain) CHECK(apart(run(less, nullptr)) > 10.0 * noise);
  }
}

TEST_CASE("Along the motion, too, a load rubs by what was recorded of its input", "[diagnose][decimate]") {
  const Plant written =
      Custom({{{"k", 9.81 / 0.8}, {"d", 0.1 / (0.6 * 0.64)}, {"b", 1.0 / (0.6 * 0.64)}}}, {"b*u - k*sin(q) - d*v"}, {});
  for (const Plant& plant : {kLoosePendulum, written}) {
    Measured whole = recorded(kLoosePendulum, 2000.0, 4.0, 3);
    RandomStream random(9);
    for (double& u : whole.input.reshaped()) u += 2.0 * draw_normal(random);
    Measured less = decimated(kLoosePendulum, {whole}, Eigen::VectorXd::Constant(1, 1e-3), 200.0).front();
    REQUIRE(less.fine != nullptr);
    // Where gravity loads the joint it stands beside some of these inputs and opposite to others.
    const auto impulse = [&](const Measured& m, double from, double to) {
      Trajectory path;
      path.position = m.position;
      path.velocity = Eigen::MatrixXd::Constant(m.position.rows(), 1, 0.7);
      path.velocity_sd = path.missing_torque = path.torque_sd = Eigen::MatrixXd::Zero(m.position.rows(), 1);
      const std::vector<Measured> data{m};
      const std::vector<Trajectory> paths{path};
      const Eigen::MatrixXd a = Forcing(plant, data, paths).acceleration({{LoadDependentFriction{0.3}, 0, -1}}, 0);
      double sum = 0.0;
      for (std::size_t k = 0; k + 1 < m.samples(); ++k) {
        if (m.time[k] >= from - 1e-9 && m.time[k + 1] <= to + 1e-9) {
          sum += a(static_cast<Eigen::Index>(k), 0) * (m.time[k + 1] - m.time[k]);
        }
      }
      return sum;
    };
    for (const double from : {0.5, 1.5, 2.5}) {
      const double exact = impulse(whole, from, from + 1.0);
      CAPTURE(plant.index(), from, exact);
      CHECK(impulse(less, from, from + 1.0) == Approx(exact).epsilon(0.02));
      Measured mean = less;
      mean.fine.reset();
      CHECK(std::abs(impulse(mean, from, from + 1.0)) < 0.97 * std::abs(exact));
    }
  }
}

TEST_CASE("An arm that is sampled at 500 Hz and lacks nothing is told so", "[diagnose][decimate][slow]") {
  const io_examples::Folder folder;
  const double noise = 1.2e-4;
  RandomStream random(11);
  std::string names;
  for (int r = 0; r < 2; ++r) {
    const Measured data = recorded(kLooseArm, 500.0, 8.0, 20 + static_cast<std::uint64_t>(r));
    Table table;
    table.columns.push_back({"t", "", data.time});
    for (int j = 0; j < 2; ++j) {
      std::vector<double> q, u;
      for (Eigen::Index k = 0; k < data.position.rows(); ++k) {
        q.push_back(data.position(k, j) + noise * draw_normal(random));
        u.push_back(data.input(k, j));
      }
      table.columns.push_back({"q" + std::to_string(j + 1), "", q});
      table.columns.push_back({"u" + std::to_string(j + 1), "", u});
    }
    write_file(folder.path() / (std::to_string(r) + ".csv"), to_csv(table));
    names += (names.empty() ? "" : ", ") + std::to_string(r) + ".csv";
  }
  write_file(
      folder.path() / "d.yaml",
      "name: arm\nmodel: {plant: two_link_arm, parameters: {mass1: 2, mass2: 1.5, length1: 0.8, length2: 0.6, com1: "
      "0.4, com2: 0.3, inertia1: 0.5, inertia2: 0.2, friction1: 0.3, friction2: 0.1}}\n"
      "signals: {time: t, position: [q1, q2], input: [u1, u2]}\nrecordings: [" +
          names + "]\n");
  const Diagnosis diagnosis = diagnose(read_diagnosis_spec(folder.path() / "d.yaml")).diagnosis;
  CHECK(diagnosis.verdict == Verdict::nothing_missing);
  CHECK(diagnosis.mismatch.p_value > 1e-3);
}
