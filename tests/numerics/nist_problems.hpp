#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace nist {

/// A problem of the NIST Statistical Reference Datasets for nonlinear regression (https://www.itl.nist.gov/div898/strd,
/// public domain): observations, model, both starts, certified parameters and residual sum of squares.
struct Problem {
  std::string name;
  std::vector<double> x, y;
  std::function<double(double x, const Eigen::VectorXd& b)> model;
  std::vector<std::vector<double>> starts;
  std::vector<double> certified;
  double sse = 0.0;
};

inline std::vector<Problem> problems() {
  using B = Eigen::VectorXd;
  return {
      {"Misra1a",
       {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0},
       {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78},
       [](double x, const B& b) { return b[0] * (1.0 - std::exp(-b[1] * x)); },
       {{500.0, 0.0001}, {250.0, 0.0005}},
       {238.94212918, 5.5015643181e-4},
       0.12455138894},
      {"DanWood",
       {1.309, 1.471, 1.490, 1.565, 1.611, 1.680},
       {2.138, 3.421, 3.597, 4.340, 4.882, 5.660},
       [](double x, const B& b) { return b[0] * std::pow(x, b[1]); },
       {{1.0, 5.0}, {0.7, 4.0}},
       {0.76886226176, 3.8604055871},
       0.0043173084083},
      {"MGH09",
       {4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625},
       {0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246},
       [](double x, const B& b) { return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]); },
       {{0.25, 0.39, 0.415, 0.39}},
       {0.19280693458, 0.19128232873, 0.12305650693, 0.13606233068},
       3.0750560385e-4},
      {"Rat42",
       {9.0, 14.0, 21.0, 28.0, 42.0, 57.0, 63.0, 70.0, 79.0},
       {8.93, 10.80, 18.59, 22.33, 39.35, 56.11, 61.73, 64.62, 67.08},
       [](double x, const B& b) { return b[0] / (1.0 + std::exp(b[1] - b[2] * x)); },
       {{100.0, 1.0, 0.1}, {75.0, 2.5, 0.07}},
       {72.462237576, 2.6180768402, 0.067359200066},
       8.0565229338},
      {"Rat43",
       {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0},
       {16.08, 33.83, 65.80, 97.20, 191.55, 326.20, 386.87, 520.53, 590.03, 651.92, 724.93, 699.56, 689.96, 637.56,
        717.41},
       [](double x, const B& b) { return b[0] / std::pow(1.0 + std::exp(b[1] - b[2] * x), 1.0 / b[3]); },
       {{100.0, 10.0, 1.0, 1.0}, {700.0, 5.0, 0.75, 1.3}},
       {699.64151270, 5.2771253025, 0.75962938329, 1.2792483859},
       8786.4049080},
      {"BoxBOD",
       {1.0, 2.0, 3.0, 5.0, 7.0, 10.0},
       {109.0, 149.0, 149.0, 191.0, 213.0, 224.0},
       [](double x, const B& b) { return b[0] * (1.0 - std::exp(-b[1] * x)); },
       {{100.0, 0.75}},
       {213.80940889, 0.54723748542},
       1168.0088766},
  };
}

}  // namespace nist
