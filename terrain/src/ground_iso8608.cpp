#include "grouser/terrain/ground_iso8608.h"

#include <complex>
#include <random>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "ground_detail.h"

namespace grouser {

namespace {

using namespace ground_detail;

constexpr double n0 = 0.1;  // [cycles/m]
constexpr int nodes_per_wave = 32;

/// Both tracks at one node: height [m] and slope times the node spacing [m], so that a point needs one or two cache
/// lines.
struct Node {
  double right, right_slope, left, left_slope;
};

class Iso8608Ground final : public GroundShape<Iso8608Ground> {
 public:
  explicit Iso8608Ground(const Iso8608Settings& p) : p_(p), f_(p.frame), inverse_width_(1 / p.track_width) {
    std::int64_t n = 64;
    while (static_cast<double>(n) < nodes_per_wave * p.period * p.highest) n *= 2;
    mask_ = n - 1;
    inverse_spacing_ = static_cast<double>(n) / p.period;
    nodes_.resize(static_cast<std::size_t>(n));
    synthesise();
  }

  double at(double x, double y) const {
    const double s = f_.along(x, y);
    if (p_.run_in > 0) {
      if (s <= 0) return 0;
      if (s < p_.run_in) return smooth(s / p_.run_in) * heights_at(place(s)).between(lateral_weight(x, y));
    }
    return heights_at(place(s)).between(lateral_weight(x, y));
  }

  Vec3 normal(double x, double y) const override {
    const double s = f_.along(x, y);
    if (p_.run_in > 0 && s <= 0) return Vec3::UnitZ();
    const double u = lateral_weight(x, y);
    const Place p = place(s);
    const Tracks z = heights_at(p);
    double g_along = slopes_at(p).between(u),
           g_across = (z.left - z.right) * smooth_slope(lateral(x, y)) * inverse_width_;
    if (p_.run_in > 0) {
      const double w = smooth(s / p_.run_in);
      g_along = w * g_along + smooth_slope(s / p_.run_in) / p_.run_in * z.between(u);
      g_across *= w;
    }
    return f_.normal(g_along, g_across);
  }

  double resolution() const override { return 1 / (nodes_per_wave * p_.highest); }

  std::string describe() const override {
    std::string t = "ISO 8608 ";
    bool named = false;
    for (char c = 'A'; c <= 'H'; ++c)
      if (p_.roughness == iso8608_roughness(c) && p_.waviness == 2) t += std::string("class ") + c, named = true;
    if (!named) t += "Gd(n0) = " + number(p_.roughness) + " m^3, w = " + number(p_.waviness);
    t += ", seed " + std::to_string(p_.seed);
    if (p_.coherence == Iso8608Settings::Coherence::full)
      t += ", one profile across";
    else
      t += ", two tracks " + number(p_.track_width) + " m apart";
    t += ", period " + number(p_.period) + " m";
    if (p_.run_in > 0) t += ", run-in " + number(p_.run_in) + " m";
    return t + frame_text(p_.frame);
  }

 private:
  struct Tracks {
    double right, left;
    double between(double u) const { return right + u * (left - right); }
  };

  double lateral(double x, double y) const { return f_.across(x, y) * inverse_width_ + 0.5; }
  double lateral_weight(double x, double y) const { return smooth(lateral(x, y)); }

  /// Place on the way: nodes before and after it, and where between them.
  struct Place {
    const Node &a, &b;
    double t, r;  ///< 0..1 and 1 - t
  };
  Place place(double s) const {
    const double q = s * inverse_spacing_;
    std::int64_t i = static_cast<std::int64_t>(q);
    if (static_cast<double>(i) > q) --i;
    const double t = q - static_cast<double>(i);
    return {nodes_[static_cast<std::size_t>(i & mask_)], nodes_[static_cast<std::size_t>((i + 1) & mask_)], t, 1 - t};
  }

  /// Cubic Hermite of both tracks.
  Tracks heights_at(const Place& p) const {
    const double ha = (1 + 2 * p.t) * p.r * p.r, ma = p.t * p.r * p.r, hb = p.t * p.t * (3 - 2 * p.t),
                 mb = -p.t * p.t * p.r;
    return {ha * p.a.right + ma * p.a.right_slope + hb * p.b.right + mb * p.b.right_slope,
            ha * p.a.left + ma * p.a.left_slope + hb * p.b.left + mb * p.b.left_slope};
  }
  Tracks slopes_at(const Place& p) const {
    const double dh = 6 * p.t * p.r, da = p.r * (p.r - 2 * p.t), db = p.t * (p.t - 2 * p.r);
    return {(dh * (p.b.right - p.a.right) + da * p.a.right_slope + db * p.b.right_slope) * inverse_spacing_,
            (dh * (p.b.left - p.a.left) + da * p.a.left_slope + db * p.b.left_slope) * inverse_spacing_};
  }

  void synthesise() {
    using Complex = std::complex<double>;
    const std::size_t n = nodes_.size();
    std::vector<Complex> right(n / 2 + 1), left(n / 2 + 1);
    std::mt19937_64 random(p_.seed);
    const auto first = static_cast<std::size_t>(std::ceil(p_.lowest * p_.period * (1 - 1e-12)));
    const auto last = static_cast<std::size_t>(std::floor(p_.highest * p_.period * (1 + 1e-12)));
    for (std::size_t k = first; k <= last; ++k) {
      const double f = static_cast<double>(k) / p_.period;
      const double amplitude = std::sqrt(2 * p_.roughness * std::pow(f / n0, -p_.waviness) / p_.period);
      // Own mapping to [0, 2 pi): the standard's distributions differ between libraries.
      const double phase = 2 * pi * static_cast<double>(random() >> 11) * 0x1p-53;
      const double sign = (random() >> 63) != 0 ? 1 : -1;
      const double lag = sign * std::acos(iso8608_coherence(p_, f));
      right[k] = std::polar(0.5 * static_cast<double>(n) * amplitude, phase);
      left[k] = std::polar(0.5 * static_cast<double>(n) * amplitude, phase + lag);
    }
    fill(right, &Node::right, &Node::right_slope);
    fill(left, &Node::left, &Node::left_slope);
  }

  void fill(std::vector<std::complex<double>>& spectrum, double Node::*height, double Node::*slope) {
    const std::size_t n = nodes_.size();
    Eigen::FFT<double> fft;
    fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    std::vector<double> z(n);
    fft.inv(z, spectrum, static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) nodes_[i].*height = z[i];
    for (std::size_t k = 0; k < spectrum.size(); ++k)
      spectrum[k] *= std::complex<double>(0, 2 * pi * static_cast<double>(k) / static_cast<double>(n));
    fft.inv(z, spectrum, static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) nodes_[i].*slope = z[i];
  }

  Iso8608Settings p_;
  Frame f_;
  std::int64_t mask_;
  double inverse_spacing_, inverse_width_;
  std::vector<Node> nodes_;
};

}  // namespace

double iso8608_roughness(char c) {
  require(c >= 'A' && c <= 'H', std::string("iso8608: class must be A..H, got '") + c + "'");
  return std::ldexp(16.0, 2 * (c - 'A')) * 1e-6;
}

double iso8608_coherence(const Iso8608Settings& p, double n) {
  switch (p.coherence) {
    case Iso8608Settings::Coherence::full:
      return 1;
    case Iso8608Settings::Coherence::exponential:
      return std::exp(-p.decay * n * p.track_width);
    case Iso8608Settings::Coherence::isotropic:
      break;
  }
  const double x = 2 * pi * n * p.track_width, nu = p.waviness / 2;
  if (x < 1e-8) return 1;
  if (x > 600) return 0;  // below the smallest normal number
  return std::min(1.0, 2 / std::tgamma(nu) * std::pow(x / 2, nu) * std::cyl_bessel_k(nu, x));
}

GroundPtr iso8608_ground(const Iso8608Settings& p) {
  check_frame(p.frame);
  require(p.roughness > 0 && std::isfinite(p.roughness), "iso8608: roughness must be positive");
  require(p.waviness >= 1 && p.waviness <= 4, "iso8608: waviness must be within 1..4");
  require(p.track_width > 0 && std::isfinite(p.track_width), "iso8608: track_width must be positive");
  require(p.decay >= 0 && std::isfinite(p.decay), "iso8608: decay must be at least 0");
  require(p.lowest > 0 && p.highest > p.lowest && std::isfinite(p.highest), "iso8608: need 0 < lowest < highest");
  require(p.period > 0 && std::isfinite(p.period), "iso8608: period must be positive");
  require(p.lowest * p.period >= 2 * (1 - 1e-12),
          "iso8608: period must be at least 2/lowest = " + number(2 / p.lowest) + " m");
  require(p.period * p.highest <= 65536,
          "iso8608: period must be at most 65536/highest = " + number(65536 / p.highest) + " m (memory)");
  require(p.run_in >= 0 && p.run_in <= p.period, "iso8608: run_in must be within 0..period");
  return std::make_shared<Iso8608Ground>(p);
}

}  // namespace grouser
