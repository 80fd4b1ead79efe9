#include "diagnose/discrepancy/left_out.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

std::vector<int> folds_of(const LinearResponse& response, const Eigen::VectorXd& target) {
  const std::vector<Segment>& windows = response.windows();
  std::vector<int> recordings, thirds;
  std::array<double, kSettings.discrepancy.folds> squares{}, rows{};
  for (std::size_t w = 0, first = 0; w < windows.size(); ++w) {
    if (windows[w].recording != windows[first].recording) first = w;
    recordings.push_back(static_cast<int>(windows[w].recording % kSettings.discrepancy.folds));
    thirds.push_back(static_cast<int>((w - first) % kSettings.discrepancy.folds));
    const auto part = static_cast<std::size_t>(recordings.back());
    squares[part] += target.segment(response.first_row(w), response.row_count(w)).squaredNorm();
    rows[part] += static_cast<double>(response.row_count(w));
  }
  double sum = 0.0, most = 0.0;
  for (std::size_t part = 0; part < kSettings.discrepancy.folds; ++part) {
    const double evident =
        std::max(0.0, squares[part] - rows[part] - kSettings.discrepancy.evident * std::sqrt(2.0 * rows[part]));
    sum += evident;
    most = std::max(most, evident);
  }
  return most > kSettings.discrepancy.nearly_all * sum ? thirds : recordings;
}

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
    part.sse = y.squaredNorm();
    whole_.gram += part.gram;
    whole_.projected += part.projected;
    whole_.sse += part.sse;
  }
  for (const Part& part : folds_) {
    others_.push_back({whole_.gram - part.gram, whole_.projected - part.projected, whole_.sse - part.sse});
  }
}

Eigen::VectorXd LeftOut::weights_from(const Part& part, const Prior& prior) {
  const Eigen::VectorXd& deviations = prior.deviations;
  Eigen::MatrixXd information = deviations.asDiagonal() * part.gram(prior.features, prior.features);
  information *= deviations.asDiagonal();
  information.diagonal().array() += 1.0;
  const Eigen::VectorXd slope = deviations.cwiseProduct(part.projected(prior.features));
  return deviations.cwiseProduct(Cholesky(information).solve(slope).col(0));
}

double LeftOut::sse(const Prior& prior) const {
  double sum = 0.0;
  for (std::size_t f = 0; f < folds_.size(); ++f) {
    const Eigen::VectorXd w = weights_from(others_[f], prior);
    const Eigen::MatrixXd gram = folds_[f].gram(prior.features, prior.features);
    sum += folds_[f].sse - 2.0 * w.dot(folds_[f].projected(prior.features)) + w.dot(gram * w);
  }
  return sum;
}

double LeftOut::target_sse() const { return whole_.sse; }

Eigen::VectorXd LeftOut::weights(const Prior& prior, int without) const {
  return weights_from(without < 0 ? whole_ : others_[static_cast<std::size_t>(without)], prior);
}

}  // namespace bayesctrl
