#pragma once
// What stored computations say between their points: polynomials for several outputs at once, with the error of that.
#include <Eigen/Core>
#include <string>
#include <vector>

namespace grouser::diagnosis {

/// y(x) = B' h(x),  h: products of powers of the scaled inputs (x - centre)/half;  B = (H'H)^-1 H'Y (G1)
/// Scatter of single runs about it: S = E'E/(n - q), E the residuals of n runs, q terms. Errors of the mean of two
/// points:
///   cov(y(x1), y(x2)) = s(x1, x2) S,  s = h(x1)' (H'H)^-1 h(x2)
/// for runs that scatter alike and independently (multivariate regression: Mardia, Kent & Bibby 1979, chapter 6).
/// Left-one-out errors without refits: E_i/(1 - h_i'(H'H)^-1 h_i).
class Emulator {
 public:
  struct Input {
    std::string name;
    double lower = 0, upper = 0;  ///< of the stored runs
    double centre = 0, half = 1;
  };
  /// Powers of each input.
  using Term = std::vector<int>;

  Emulator() = default;
  /// x: runs by inputs, y: runs by outputs. @throws std::invalid_argument: sizes, or runs that do not fix every term.
  Emulator(std::vector<Input> inputs, std::vector<Term> terms, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);

  const std::vector<Input>& inputs() const { return inputs_; }
  int outputs() const { return static_cast<int>(B_.cols()); }
  int runs() const { return static_cast<int>(left_out_.rows()); }
  int dof() const { return runs() - static_cast<int>(terms_.size()); }
  /// Within the range of the stored runs; beyond it there is no answer.
  bool inside(const Eigen::VectorXd& x) const;
  Eigen::VectorXd features(const Eigen::VectorXd& x) const;
  Eigen::VectorXd mean(const Eigen::VectorXd& features) const { return B_.transpose() * features; }
  /// s of two points, by their features.
  double share(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const { return a.dot(inverse_ * b); }
  const Eigen::MatrixXd& scatter() const { return S_; }
  const Eigen::MatrixXd& left_out() const { return left_out_; }  ///< runs by outputs

 private:
  std::vector<Input> inputs_;
  std::vector<Term> terms_;
  Eigen::MatrixXd B_, inverse_, S_, left_out_;
};

/// All products of powers up to `degree` in the inputs listed, of `count` inputs.
std::vector<Emulator::Term> polynomial_terms(int count, const std::vector<int>& inputs, int degree);

}  // namespace grouser::diagnosis
