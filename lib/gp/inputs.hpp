#pragma once

#include <Eigen/Core>

namespace bayesctrl {

/// Inputs per call of a kernel: what stays in the first-level cache, on the stack.
inline constexpr int kBlock = 64;

/// One number per input of a block.
using BlockArray = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kBlock, 1>;

/// Most hyper-parameters of one kernel, composite kernels included.
inline constexpr int kMaxHyperParameters = 32;

/// One row per input of a block, one column per hyper-parameter.
using BlockGradient =
    Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kBlock, kMaxHyperParameters>;

/// A view of up to kBlock inputs, stored dimension after dimension.
struct InputBlock {
  const double* data = nullptr;
  Eigen::Index stride = 0;
  int count = 0;
  int dimension = 0;

  Eigen::Map<const BlockArray> column(int d) const { return {data + d * stride, count}; }
};

/// Inputs of the training points: n points in `dimension` dimensions, stored dimension after dimension (contiguous, so
/// that kernels vectorise), with spare room to grow. Room beyond n is zero.
class Inputs {
 public:
  Inputs() = default;
  explicit Inputs(int dimension) : values_(Eigen::MatrixXd::Zero(0, dimension)) {}

  int size() const { return size_; }
  int dimension() const { return static_cast<int>(values_.cols()); }
  auto points() const { return values_.topRows(size_); }

  void reserve(int samples) {
    const Eigen::Index room = (samples + kBlock - 1) / kBlock * kBlock;
    const Eigen::Index before = values_.rows();
    if (room <= before) return;
    values_.conservativeResize(room, Eigen::NoChange);
    values_.bottomRows(room - before).setZero();
  }

  void append(const double* x) {
    if (size_ == values_.rows()) reserve(2 * size_ + kBlock);
    for (int d = 0; d < dimension(); ++d) values_(size_, d) = x[d];
    ++size_;
  }

  /// Leaves out point i; those behind it move up.
  void erase(int i) {
    for (int d = 0; d < dimension(); ++d) {
      for (int k = i; k + 1 < size_; ++k) values_(k, d) = values_(k + 1, d);
      values_(size_ - 1, d) = 0.0;
    }
    --size_;
  }

  /// Points first .. first + count - 1; may reach into the zeros beyond the last point, up to a multiple of kBlock.
  InputBlock block(int first, int count) const { return {values_.data() + first, values_.rows(), count, dimension()}; }

 private:
  Eigen::MatrixXd values_;
  int size_ = 0;
};

}  // namespace bayesctrl
