#include "blend.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace grouser::sdem {

namespace {

/// Lower node of the interval around x and the share of its upper one.
struct Place {
  std::size_t at;
  double share;
};

Place place_of(const std::vector<double>& nodes, double x) {
  if (nodes.size() == 1) return {0, 0};
  const auto up = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
  const std::size_t i = static_cast<std::size_t>(up - nodes.begin()) - 1;
  return {i, (x - nodes[i]) / (nodes[i + 1] - nodes[i])};
}

/// Lower index on an even axis and the share of the next one.
struct Step {
  int at;
  float share;
};
Step step_of(const Axis& a, double x) {
  const double k = (x - a.first) / a.step();
  const int i = std::clamp(static_cast<int>(k), 0, a.count - 2);
  return {i, static_cast<float>(k - i)};
}

}  // namespace

Blend::Blend(std::shared_ptr<const Tables> tables) : tables_(std::move(tables)) {
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    const Grid& g = tables_->parts[p];
    rows_[p].x.resize(g.plane());
    rows_[p].z.resize(g.plane());
    rows_[p].ready.assign(static_cast<std::size_t>(g.u.count), 0);
  }
}

void Blend::set(const Velocity& V) {
  if (V == velocity_) return;
  velocity_ = V;
  const Tables& t = *tables_;
  const Place w = place_of(t.w, V.w), x = place_of(t.vx, V.vx), z = place_of(t.vz, V.vz);
  corners_.clear();
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j)
      for (std::size_t k = 0; k < 2; ++k) {
        const double weight = (i ? w.share : 1 - w.share) * (j ? x.share : 1 - x.share) * (k ? z.share : 1 - z.share);
        if (weight != 0) corners_.push_back({t.node(w.at + i, x.at + j, z.at + k), static_cast<float>(weight)});
      }
  for (Rows& r : rows_) std::fill(r.ready.begin(), r.ready.end(), std::uint8_t{0});
}

void Blend::blend_row(std::size_t part, int row) {
  const Grid& g = tables_->parts[part];
  Rows& r = rows_[part];
  r.ready[static_cast<std::size_t>(row)] = 1;
  const auto n = static_cast<std::size_t>(g.v.count), to = static_cast<std::size_t>(row) * n;
  const auto blend = [&](const std::vector<float>& from, float* out) {
    std::fill(out, out + n, 0.0F);
    for (const Corner& c : corners_) {
      const float* in = from.data() + g.index(c.node, row, 0);
      for (std::size_t k = 0; k < n; ++k) out[k] += c.weight * in[k];
    }
  };
  blend(g.x, r.x.data() + to);
  blend(g.z, r.z.data() + to);
}

Pair Blend::at(Part part, double u, double v) {
  const auto p = static_cast<std::size_t>(part);
  const Grid& g = tables_->parts[p];
  Rows& r = rows_[p];
  const Step a = step_of(g.u, u), b = step_of(g.v, v);
  for (int row = a.at; row <= a.at + 1; ++row)
    if (!r.ready[static_cast<std::size_t>(row)]) blend_row(p, row);
  const std::size_t k = static_cast<std::size_t>(a.at) * static_cast<std::size_t>(g.v.count) +
                        static_cast<std::size_t>(b.at),
                    next = k + static_cast<std::size_t>(g.v.count);
  const auto value = [&](const std::vector<float>& f) {
    const float low = f[k] + b.share * (f[k + 1] - f[k]), high = f[next] + b.share * (f[next + 1] - f[next]);
    return static_cast<double>(low + a.share * (high - low));
  };
  return {value(r.x), value(r.z)};
}

std::string outside(const Tables& t, const Velocity& V) {
  const auto check = [](const char* name, const char* unit, double x, const std::vector<double>& nodes) {
    // Beyond the last digits of a host's velocity.
    const double slack = 1e-9 * std::max(std::abs(nodes.front()), std::abs(nodes.back()));
    if (x >= nodes.front() - slack && x <= nodes.back() + slack) return std::string();
    char text[160];
    std::snprintf(text, sizeof text, "%s = %.6g %s, tables hold %.6g to %.6g", name, x, unit, nodes.front(),
                  nodes.back());
    return std::string(text);
  };
  std::string all;
  for (const std::string& s :
       {check("w", "rad/s", V.w, t.w), check("vx", "m/s", V.vx, t.vx), check("vz", "m/s", V.vz, t.vz)})
    if (!s.empty()) all += (all.empty() ? "" : "; ") + s;
  return all;
}

Velocity nearest(const Tables& t, Velocity V) {
  V.w = std::clamp(V.w, t.w.front(), t.w.back());
  V.vx = std::clamp(V.vx, t.vx.front(), t.vx.back());
  V.vz = std::clamp(V.vz, t.vz.front(), t.vz.back());
  return V;
}

}  // namespace grouser::sdem
