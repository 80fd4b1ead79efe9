#include "diagnose/left_out.hpp"

#include <Eigen/Cholesky>

namespace bayesctrl {

LeftOut::LeftOut(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, const std::vector<int>& fold,
                 int folds) {
  const Eigen::Index features = columns.cols();
  whole_ = {Eigen::MatrixXd::Zero(features, features), Eigen::VectorXd::Zero(features), 0.0};
  for (int f = 0; f < folds; ++f) {
    std::vector<Eigen::Index> rows;
    for (std::size_t row = 0; row < fold.size(); ++row) {
      if (fold[row] == f) rows.push_back(static_cast<Eigen::Index>(row));
    }
    const Eigen::MatrixXd own = columns(rows, Eigen::all);
    const Eigen::VectorXd y = target(rows);
    Part& part = folds_.emplace_back();
    part.gram = own.transpose() * own;
    part.projected = own.transpose() * y;
    part.squares = y.squaredNorm();
    whole_.gram += part.gram;
    whole_.projected += part.projected;
    whole_.squares += part.squares;
  }
}

Eigen::VectorXd LeftOut::solve(const Prior& prior, const Part& without) const {
  const auto count = static_cast<Eigen::Index>(prior.features.size());
  Eigen::MatrixXd information(count, count);
  Eigen::VectorXd slope(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Eigen::Index of_j = prior.features[static_cast<std::size_t>(j)];
    for (Eigen::Index i = j; i < count; ++i) {
      const Eigen::Index of_i = prior.features[static_cast<std::size_t>(i)];
      double sum = whole_.gram(of_i, of_j);
      if (without.gram.size() > 0) sum -= without.gram(of_i, of_j);
      information(i, j) = prior.deviations[i] * sum * prior.deviations[j];
    }
    double sum = whole_.projected[of_j];
    if (without.gram.size() > 0) sum -= without.projected[of_j];
    slope[j] = prior.deviations[j] * sum;
  }
  information.diagonal().array() += 1.0;
  return prior.deviations.cwiseProduct(information.selfadjointView<Eigen::Lower>().llt().solve(slope));
}

double LeftOut::squares(const Prior& prior) const {
  double sum = 0.0;
  for (const Part& part : folds_) {
    const Eigen::VectorXd w = solve(prior, part);
    const Eigen::MatrixXd gram = part.gram(prior.features, prior.features);
    sum += part.squares - 2.0 * w.dot(part.projected(prior.features)) + w.dot(gram * w);
  }
  return sum;
}

double LeftOut::all() const { return whole_.squares; }

Eigen::VectorXd LeftOut::weights(const Prior& prior, int without) const {
  return solve(prior, without < 0 ? Part{} : folds_[static_cast<std::size_t>(without)]);
}

}  // namespace bayesctrl
