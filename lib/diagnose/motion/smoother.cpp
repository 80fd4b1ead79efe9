#include "diagnose/motion/smoother.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

/// So many numbers for each joint; where the number of joints is no constant that is none, and the most are.
constexpr int numbers(int each, int joints) { return joints == Eigen::Dynamic ? Eigen::Dynamic : each * joints; }
constexpr int most_numbers(int each, int joints) { return each * (joints == Eigen::Dynamic ? kMaxJoints : joints); }

template <int kJoints, int kRows, int kColumns>
using Numbers = Eigen::Matrix<double, numbers(kRows, kJoints), numbers(kColumns, kJoints), Eigen::ColMajor,
                              most_numbers(kRows, kJoints), most_numbers(kColumns, kJoints)>;

// One function per operation: as expressions each of these products would be compiled anew where it stands.
template <class Square>
Square product(const Square& a, const Square& b) {
  return a * b;
}
template <class Square>
Square product_with_transpose(const Square& a, const Square& b) {
  return a * b.transpose();
}
/// a += scale x x'.
template <class Square, class State>
void add_outer(Square& a, const State& x, double scale) {
  a.noalias() += scale * x * x.transpose();
}

/// d(q'')/d[q, v] at one point, transposed: 2 joints x joints, by central differences.
template <int kJoints>
Numbers<kJoints, 2, 1> slope(const Plant& plant, const Joints<kJoints>& q, const Joints<kJoints>& v,
                             const Joints<kJoints>& u, double t) {
  const Eigen::Index n = q.size();
  Numbers<kJoints, 2, 1> result(2 * n, n);
  constexpr double kStep = 1e-5;
  const auto acceleration = [&](const Joints<kJoints>& at, const Joints<kJoints>& speed) {
    return motion_of<kJoints>(plant, at, speed, u, t).acceleration;
  };
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    Joints<kJoints> q1 = q, v1 = v, q2 = q, v2 = v;
    (i < n ? q1[i] : v1[i - n]) += kStep;
    (i < n ? q2[i] : v2[i - n]) -= kStep;
    result.row(i) = (acceleration(q1, v1) - acceleration(q2, v2)).transpose() / (2.0 * kStep);
  }
  return result;
}

template <int kJoints>
Joints<kJoints> input_of(const Measured& data, std::size_t k, double s) {
  const auto row = static_cast<Eigen::Index>(k);
  if (!data.linear_hold || k + 1 >= data.samples()) return data.input.row(row).transpose();
  return ((1.0 - s) * data.input.row(row) + s * data.input.row(row + 1)).transpose();
}

template <int kJoints>
void propagate_of(const Plant& plant, Joints<kJoints>& q, Joints<kJoints>& v, const Measured& data, std::size_t k,
                  const Joints<kJoints>& missing_torque) {
  const double t = data.time[k], h = data.time[k + 1] - t;
  const auto rate = [&](const Joints<kJoints>& at, const Joints<kJoints>& speed, double s) -> Joints<kJoints> {
    const MotionOf<kJoints> m = motion_of<kJoints>(plant, at, speed, input_of<kJoints>(data, k, s), t + s * h);
    return m.acceleration + m.mobility * missing_torque;
  };
  const Joints<kJoints> a1 = rate(q, v, 0.0), v2 = v + 0.5 * h * a1;
  const Joints<kJoints> a2 = rate(q + 0.5 * h * v, v2, 0.5), v3 = v + 0.5 * h * a2;
  const Joints<kJoints> a3 = rate(q + 0.5 * h * v2, v3, 0.5), v4 = v + h * a3;
  const Joints<kJoints> a4 = rate(q + h * v3, v4, 1.0);
  q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
  v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
}

/// One pass of the filter over a stretch; keeps what the smoother needs if asked.
template <int kJoints>
class Filter {
  using State = Eigen::Matrix<double, numbers(3, kJoints), 1, Eigen::ColMajor, most_numbers(3, kJoints), 1>;
  using Square = Numbers<kJoints, 3, 3>;

 public:
  Filter(const Plant& plant, const Measured& data, const Eigen::VectorXd& noise, const std::vector<TorquePrior>& prior)
      : plant_(plant), data_(data), noise_(noise), prior_(prior), n_(noise.size()) {}

  /// Log likelihood of the stretch.
  double run(const Segment& stretch, Trajectory* out) {
    const Eigen::Index n = n_, size = 3 * n;
    const std::size_t count = stretch.samples();
    State x = State::Zero(size);
    Square p = Square::Zero(size, size);
    start(stretch, x, p);
    std::vector<State> filtered, predicted;
    std::vector<Square> filtered_p, predicted_p, transition;
    if (out != nullptr) {
      for (auto* list : {&filtered, &predicted}) list->reserve(count);
      for (auto* list : {&filtered_p, &predicted_p, &transition}) list->reserve(count);
    }
    double likelihood = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = stretch.first + i;
      if (i > 0) {
        const Square phi = step(k - 1, x, p);
        if (out != nullptr) transition.push_back(phi);
      }
      if (out != nullptr) {
        predicted.push_back(x);
        predicted_p.push_back(p);
      }
      for (Eigen::Index j = 0; j < n; ++j) {
        const double variance = p(j, j) + noise_[j] * noise_[j];
        const double surprise = data_.position(static_cast<Eigen::Index>(k), j) - x[j];
        likelihood -= 0.5 * (surprise * surprise / variance + std::log(variance));
        const State gain = p.col(j) / variance;
        x += gain * surprise;
        add_outer(p, gain, -variance);
      }
      if (!x.allFinite()) return -kInfinity;
      if (out != nullptr) {
        filtered.push_back(x);
        filtered_p.push_back(p);
      }
    }
    if (out == nullptr) return likelihood;
    State smoothed = filtered.back();
    Square smoothed_p = filtered_p.back();
    for (std::size_t i = count; i-- > 0;) {
      if (i + 1 < count) {
        const Square inverse = predicted_p[i + 1].partialPivLu().inverse();
        const Square gain = product(product_with_transpose(filtered_p[i], transition[i]), inverse);
        smoothed = filtered[i] + gain * State(smoothed - predicted[i + 1]);
        smoothed_p =
            filtered_p[i] + product_with_transpose(product(gain, Square(smoothed_p - predicted_p[i + 1])), gain);
      }
      const auto row = static_cast<Eigen::Index>(stretch.first + i);
      out->position.row(row) = smoothed.head(n);
      out->velocity.row(row) = smoothed.segment(n, n);
      out->missing_torque.row(row) = smoothed.tail(n);
      for (Eigen::Index j = 0; j < n; ++j) {
        out->velocity_sd(row, j) = std::sqrt(std::max(0.0, smoothed_p(n + j, n + j)));
        out->torque_sd(row, j) = std::sqrt(std::max(0.0, smoothed_p(2 * n + j, 2 * n + j)));
      }
    }
    return likelihood;
  }

 private:
  /// Position and velocity from a straight line through the first samples.
  void start(const Segment& stretch, State& x, Square& p) const {
    const auto first = static_cast<Eigen::Index>(stretch.first);
    const auto few = static_cast<Eigen::Index>(std::min<std::size_t>(stretch.samples(), 8));
    const double span =
        std::max(1e-9, data_.time[stretch.first + static_cast<std::size_t>(few) - 1] - data_.time[stretch.first]);
    for (Eigen::Index j = 0; j < n_; ++j) {
      x[j] = data_.position(first, j);
      x[n_ + j] = (data_.position(first + few - 1, j) - data_.position(first, j)) / span;
      p(j, j) = 100.0 * noise_[j] * noise_[j];
      const double doubt = 10.0 * noise_[j] / span + 0.5 * std::abs(x[n_ + j]) + 20.0 * span;
      p(n_ + j, n_ + j) = doubt * doubt;
      const double deviation = prior_[static_cast<std::size_t>(j)].deviation;
      p(2 * n_ + j, 2 * n_ + j) = deviation * deviation;
    }
  }

  /// Moves mean and covariance from sample k to k + 1; returns the transition matrix.
  Square step(std::size_t k, State& x, Square& p) const {
    const Eigen::Index n = n_, size = 3 * n;
    const double h = data_.time[k + 1] - data_.time[k];
    Joints<kJoints> q = x.head(n), v = x.segment(n, n);
    const Joints<kJoints> d = x.tail(n), u = input_of<kJoints>(data_, k, 0.5);
    const auto a = slope<kJoints>(plant_, q, v, u, data_.time[k]);
    const JointsSquare<kJoints> mobility = motion_of<kJoints>(plant_, q, v, u, data_.time[k]).mobility;
    propagate_of<kJoints>(plant_, q, v, data_, k, d);
    Square rate = Square::Zero(size, size);
    rate.block(0, n, n, n).setIdentity();
    rate.block(n, 0, n, 2 * n) = a.transpose();
    rate.block(n, 2 * n, n, n) = mobility;
    const Square square = product(rate, rate), cube = product(square, rate);
    Square phi = Square::Identity(size, size) + h * rate + 0.5 * h * h * square + h * h * h / 6.0 * cube;
    Square q_noise = Square::Zero(size, size);
    for (Eigen::Index j = 0; j < n; ++j) {
      const TorquePrior& prior = prior_[static_cast<std::size_t>(j)];
      const double decay = std::exp(-h / prior.correlation);
      phi(2 * n + j, 2 * n + j) = decay;
      const double variance = prior.deviation * prior.deviation * (1.0 - decay * decay);
      // The torque's noise within the step, as a ramp: it reaches v with h / 2 and q with h^2 / 6.
      State push = State::Zero(size);
      push[2 * n + j] = 1.0;
      for (Eigen::Index i = 0; i < n; ++i) {
        push[n + i] = 0.5 * h * mobility(i, j);
        push[i] = h * h / 6.0 * mobility(i, j);
      }
      add_outer(q_noise, push, variance);
      x[2 * n + j] *= decay;
    }
    x.head(n) = q;
    x.segment(n, n) = v;
    p = product_with_transpose(product(phi, p), phi) + q_noise;
    p = (0.5 * (p + p.transpose())).eval();
    for (Eigen::Index i = 0; i < 2 * n; ++i) p(i, i) += 1e-18;
    return phi;
  }

  const Plant& plant_;
  const Measured& data_;
  const Eigen::VectorXd& noise_;
  const std::vector<TorquePrior>& prior_;
  Eigen::Index n_;
};

/// Log likelihood of a recording under a prior; the motion is what was asked for. Of one or two joints the filter's
/// matrices are arrays.
double filtered(const Plant& plant, const Measured& data, const Eigen::VectorXd& noise,
                const std::vector<TorquePrior>& prior, Trajectory* out) {
  const auto run = [&](auto filter) {
    double likelihood = 0.0;
    for (const Segment& stretch : stretches(data, 0)) likelihood += filter.run(stretch, out);
    return likelihood;
  };
  if (noise.size() == 1) return run(Filter<1>(plant, data, noise, prior));
  if (noise.size() == 2) return run(Filter<2>(plant, data, noise, prior));
  return run(Filter<Eigen::Dynamic>(plant, data, noise, prior));
}

}  // namespace

JointVector input_at(const Measured& data, std::size_t k, double s) { return input_of<Eigen::Dynamic>(data, k, s); }

void propagate(const Plant& plant, JointVector& q, JointVector& v, const Measured& data, std::size_t k,
               const JointVector& missing_torque) {
  propagate_of<Eigen::Dynamic>(plant, q, v, data, k, missing_torque);
}

Trajectory smooth(const Plant& plant, const Measured& data, const Eigen::VectorXd& noise,
                  const std::vector<TorquePrior>& prior) {
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(data.position.rows(), data.position.cols());
  Trajectory result{data.position, zero, zero, zero, zero};
  filtered(plant, data, noise, prior, &result);
  return result;
}

std::vector<Trajectory> smooth_all(const Plant& plant, const std::vector<Measured>& data,
                                   const Eigen::VectorXd& noise) {
  const std::vector<TorquePrior> prior = likely_torque_prior(plant, data, noise);
  std::vector<Trajectory> paths;
  for (const Measured& m : data) paths.push_back(smooth(plant, m, noise, prior));
  return paths;
}

Eigen::VectorXd torque_scale(const Plant& plant, const std::vector<Measured>& data) {
  const Eigen::Index n = data.front().position.cols();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  double count = 0.0;
  for (const Measured& m : data) {
    // Torque of the nominal at the measured motion, speeds from differences over about 0.05 s.
    const auto reach = static_cast<std::size_t>(std::max(1.0, std::round(0.03 / sample_period(m.time))));
    for (std::size_t k = reach; k + reach < m.samples(); k += reach) {
      const JointVector q = m.position.row(static_cast<Eigen::Index>(k)).transpose();
      const JointVector v =
          (m.position.row(static_cast<Eigen::Index>(k + reach)) - m.position.row(static_cast<Eigen::Index>(k - reach)))
              .transpose() /
          (m.time[k + reach] - m.time[k - reach]);
      const JointVector u = input_at(m, k, 0.0), none = JointVector::Zero(n);
      const Motion driven = motion(plant, q, v, u, m.time[k]), idle = motion(plant, q, v, none, m.time[k]);
      const JointSolver inertia(driven.mobility);
      const JointVector motor = inertia.solve(JointVector(driven.acceleration - idle.acceleration));
      const JointVector inner = inertia.solve(idle.acceleration);
      squares += motor.cwiseAbs2() + inner.cwiseAbs2();
      count += 1.0;
    }
  }
  return (squares / std::max(1.0, count)).cwiseSqrt();
}

std::vector<TorquePrior> likely_torque_prior(const Plant& plant, const std::vector<Measured>& data,
                                             const Eigen::VectorXd& noise) {
  const Eigen::VectorXd scale = torque_scale(plant, data);
  std::vector<TorquePrior> best;
  double highest = -kInfinity;
  constexpr int kSteps = 8;
  for (int i = 0; i < kSteps; ++i) {
    std::vector<TorquePrior> prior;
    for (const double s : scale) prior.push_back({std::max(s, 1e-9) * std::pow(10.0, -3.5 + 0.5 * i), 0.3});
    double likelihood = 0.0;
    for (const Measured& m : data) likelihood += filtered(plant, m, noise, prior, nullptr);
    if (likelihood > highest) {
      highest = likelihood;
      best = prior;
    }
  }
  return best.empty() ? std::vector<TorquePrior>(static_cast<std::size_t>(noise.size())) : best;
}

}  // namespace bayesctrl
