#include "grouser/terrain/ground_sum.h"

#include <algorithm>
#include <array>

#include "ground_detail.h"
#include "grouser/terrain/ground_extent.h"

namespace grouser {

namespace {

class SumGround final : public Ground, public GroundWithData {
 public:
  explicit SumGround(std::vector<GroundPtr> parts) : parts_(std::move(parts)) {}

  double height(double x, double y) const override {
    double h = parts_[0]->height(x, y);
    for (std::size_t i = 1; i < parts_.size(); ++i) h += parts_[i]->height(x, y);
    return h;
  }
  // Each part fills the whole line; the points keep x0 + i dx of the whole line, so the bits equal height().
  void heights(double x0, double y0, double dx, double dy, int n, double* out) const override {
    parts_[0]->heights(x0, y0, dx, dy, n, out);
    std::array<double, 256> small;
    std::vector<double> large;
    double* h = small.data();
    if (n > static_cast<int>(small.size())) {
      large.resize(static_cast<std::size_t>(n));
      h = large.data();
    }
    for (std::size_t k = 1; k < parts_.size(); ++k) {
      parts_[k]->heights(x0, y0, dx, dy, n, h);
      for (int i = 0; i < n; ++i) out[i] += h[i];
    }
  }
  Vec3 normal(double x, double y) const override {
    double gx = 0, gy = 0;
    for (const GroundPtr& p : parts_) {
      const Vec3 n = p->normal(x, y);
      gx -= n.x() / n.z();
      gy -= n.y() / n.z();
    }
    return ground_detail::normal_from_gradient(gx, gy);
  }
  double resolution() const override {
    double r = parts_[0]->resolution();
    for (const GroundPtr& p : parts_) r = std::min(r, p->resolution());
    return r;
  }
  std::string beyond_data(double x, double y) const override {
    for (const GroundPtr& p : parts_)
      if (std::string t = grouser::beyond_data(*p, x, y); !t.empty()) return t;
    return {};
  }
  std::string describe() const override {
    std::string t = parts_[0]->describe();
    for (std::size_t i = 1; i < parts_.size(); ++i) t += " + " + parts_[i]->describe();
    return t;
  }

 private:
  std::vector<GroundPtr> parts_;
};

}  // namespace

GroundPtr sum_ground(std::vector<GroundPtr> parts) {
  ground_detail::require(!parts.empty(), "a sum of grounds needs at least one");
  for (const GroundPtr& p : parts) ground_detail::require(p != nullptr, "a sum of grounds got an empty part");
  if (parts.size() == 1) return parts[0];
  return std::make_shared<SumGround>(std::move(parts));
}

}  // namespace grouser
