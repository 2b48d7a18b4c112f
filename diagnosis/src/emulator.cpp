#include "emulator.h"

#include <Eigen/QR>
#include <stdexcept>

namespace grouser::diagnosis {

Emulator::Emulator(std::vector<Input> inputs, std::vector<Term> terms, const Eigen::MatrixXd& x,
                   const Eigen::MatrixXd& y)
    : inputs_(std::move(inputs)), terms_(std::move(terms)) {
  const Eigen::Index n = x.rows(), q = static_cast<Eigen::Index>(terms_.size());
  if (y.rows() != n || x.cols() != static_cast<Eigen::Index>(inputs_.size()))
    throw std::invalid_argument("emulator: inputs and outputs do not belong together");
  if (n < q + 2)
    throw std::invalid_argument("emulator: " + std::to_string(n) + " runs for " + std::to_string(q) + " terms");
  Eigen::MatrixXd H(n, q);
  for (Eigen::Index i = 0; i < n; ++i) H.row(i) = features(x.row(i)).transpose();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(H);
  if (qr.rank() < q) throw std::invalid_argument("emulator: the runs do not fix every term");
  B_ = qr.solve(y);
  const Eigen::MatrixXd R = qr.matrixR().topLeftCorner(q, q).triangularView<Eigen::Upper>();
  const Eigen::MatrixXd root =
      R.triangularView<Eigen::Upper>().solve<Eigen::OnTheLeft>(Eigen::MatrixXd::Identity(q, q));
  const Eigen::MatrixXd turned = qr.colsPermutation() * root;
  inverse_ = turned * turned.transpose();
  const Eigen::MatrixXd E = y - H * B_;
  S_ = E.transpose() * E / static_cast<double>(n - q);
  left_out_.resize(n, y.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    left_out_.row(i) = E.row(i) / std::max(1 - share(H.row(i).transpose(), H.row(i).transpose()), 1e-12);
}

bool Emulator::inside(const Eigen::VectorXd& x) const {
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const double slack = 1e-9 * (inputs_[i].upper - inputs_[i].lower), v = x[static_cast<Eigen::Index>(i)];
    if (!(v >= inputs_[i].lower - slack && v <= inputs_[i].upper + slack)) return false;
  }
  return true;
}

Eigen::VectorXd Emulator::features(const Eigen::VectorXd& x) const {
  Eigen::VectorXd h = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(terms_.size()));
  for (std::size_t t = 0; t < terms_.size(); ++t)
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      const double z = (x[static_cast<Eigen::Index>(i)] - inputs_[i].centre) / inputs_[i].half;
      for (int k = 0; k < terms_[t][i]; ++k) h[static_cast<Eigen::Index>(t)] *= z;
    }
  return h;
}

std::vector<Emulator::Term> polynomial_terms(int count, const std::vector<int>& inputs, int degree) {
  std::vector<Emulator::Term> out{Emulator::Term(static_cast<std::size_t>(count), 0)};
  std::size_t from = 0;
  for (int d = 1; d <= degree;
       ++d) {  // each product of degree d from one of degree d - 1, its last factor not before the ones there
    const std::size_t to = out.size();
    for (std::size_t t = from; t < to; ++t)
      for (std::size_t k = 0; k < inputs.size(); ++k) {
        bool ordered = true;
        for (std::size_t later = k + 1; later < inputs.size(); ++later)
          ordered = ordered && out[t][static_cast<std::size_t>(inputs[later])] == 0;
        if (!ordered) continue;
        Emulator::Term term = out[t];
        ++term[static_cast<std::size_t>(inputs[k])];
        out.push_back(term);
      }
    from = to;
  }
  return out;
}

}  // namespace grouser::diagnosis
