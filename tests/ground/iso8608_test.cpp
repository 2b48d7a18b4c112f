// ISO 8608: PSD, coherence, reproducibility, interpolation. The estimator (Welch) knows nothing of how the road was
// made.
#include <complex>
#include <functional>
#include <map>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "grouser/terrain/ground_iso8608.h"
#include "helpers.h"

namespace grouser {
namespace {

using Complex = std::complex<double>;
constexpr double pi_ = std::numbers::pi;

/// One-sided spectra of two lines, Hann window, half overlap.
struct Welch {
  Welch(const std::vector<double>& a, const std::vector<double>& b, double dx, std::size_t n)
      : df(1 / (static_cast<double>(n) * dx)) {
    Eigen::FFT<double> fft;
    std::vector<double> w(n), xa(n), xb(n);
    double power = 0;
    for (std::size_t i = 0; i < n; ++i) {
      w[i] = 0.5 - 0.5 * std::cos(2 * pi_ * static_cast<double>(i) / static_cast<double>(n));
      power += w[i] * w[i];
    }
    aa.assign(n / 2, 0), bb.assign(n / 2, 0), ab.assign(n / 2, Complex(0));
    for (std::size_t begin = 0; begin + n <= a.size(); begin += n / 2, ++segments) {
      for (std::size_t i = 0; i < n; ++i) xa[i] = w[i] * a[begin + i], xb[i] = w[i] * b[begin + i];
      std::vector<Complex> fa, fb;
      fft.fwd(fa, xa);
      fft.fwd(fb, xb);
      for (std::size_t k = 0; k < n / 2; ++k) {
        aa[k] += std::norm(fa[k]);
        bb[k] += std::norm(fb[k]);
        ab[k] += std::conj(fa[k]) * fb[k];
      }
    }
    const double scale = 2 * dx / power / segments;
    for (std::size_t k = 0; k < n / 2; ++k) aa[k] *= scale, bb[k] *= scale, ab[k] *= scale;
  }
  double df;
  int segments = 0;
  std::vector<double> aa, bb;
  std::vector<Complex> ab;
};

std::vector<double> line(const Ground& g, double y, double dx, int n) {
  std::vector<double> z(static_cast<std::size_t>(n));
  g.heights(0, y, dx, 0, n, z.data());
  return z;
}

constexpr double dx = 0.125;           // Nyquist 4 cycles/m, above the highest 2.83
constexpr int samples = 64000;         // 8 km
constexpr std::size_t segment = 4096;  // 512 m

Iso8608Settings long_road(std::uint64_t seed) {
  Iso8608Settings p;
  p.track_width = 1.5;
  p.period = 8000;
  p.seed = seed;
  return p;
}

class IsoClass : public testing::TestWithParam<char> {};

TEST_P(IsoClass, HasThePsdOfTheClassInEveryOctaveBandAndItsVariance) {
  // ISO 8608 Table C.1: geometric mean of Gd at 0.1 cycles/m in 1e-6 m^3.
  const std::map<char, double> published = {{'A', 16},   {'B', 64},    {'C', 256},   {'D', 1024},
                                            {'E', 4096}, {'F', 16384}, {'G', 65536}, {'H', 262144}};
  Iso8608Settings p = long_road(100 + static_cast<std::uint64_t>(GetParam()));
  p.roughness = iso8608_roughness(GetParam());
  const GroundPtr g = iso8608_ground(p);
  const std::vector<double> right = line(*g, -0.75, dx, samples), left = line(*g, 0.75, dx, samples);
  const Welch w(right, left, dx, segment);
  int bands = 0;
  for (double lower = 0.0221; lower < 2; lower *= 2, ++bands) {
    double ratio_a = 0, ratio_b = 0;
    int bins = 0;
    for (std::size_t k = 1; k < segment / 2; ++k) {
      const double n = static_cast<double>(k) * w.df;
      if (n < lower || n >= 2 * lower || n > 2.8) continue;
      const double truth = published.at(GetParam()) * 1e-6 * std::pow(n / 0.1, -2);
      ratio_a += w.aa[k] / truth;
      ratio_b += w.bb[k] / truth;
      ++bins;
    }
    // Of the values averaged, half-overlapping Hann segments count 0.9 and neighbouring bins 1/1.5; each has a relative
    // deviation of 1. Five
    // deviations, and 3 % for the curvature of n^-2 over the window's 0.004 cycles/m in the lowest band.
    const double tolerance = 5 / std::sqrt(w.segments * 0.9 * bins / 1.5) + 0.03;
    ASSERT_LT(tolerance, 0.5);
    EXPECT_NEAR(ratio_a / bins, 1, tolerance) << "band from " << lower << " cycles/m, right track";
    EXPECT_NEAR(ratio_b / bins, 1, tolerance) << "band from " << lower << " cycles/m, left track";
  }
  EXPECT_EQ(bands, 7);

  for (const std::vector<double>& z : {right, left}) {
    double mean = 0, square = 0;
    for (double h : z) mean += h / samples, square += h * h / samples;
    // int Gd0 n0^2 n^-2 dn; the sum over lines 1/8000 cycles/m apart differs from it by half a line at the lower edge:
    // 0.6 %.
    const double variance = published.at(GetParam()) * 1e-6 * 0.01 * (1 / 0.011 - 1 / 2.83);
    EXPECT_NEAR(mean, 0, 1e-9);
    EXPECT_NEAR(square / variance, 1, 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(AtoH, IsoClass, testing::Values('A', 'B', 'C', 'D', 'E', 'F', 'G', 'H'),
                         [](const auto& c) { return std::string(1, c.param); });

/// Band means of Re(S_ab)/sqrt(S_aa S_bb).
void expect_coherence(const Iso8608Settings& p, const std::function<double(double)>& truth) {
  const GroundPtr g = iso8608_ground(p);
  const double half = p.track_width / 2;
  const Welch w(line(*g, -half, dx, samples), line(*g, half, dx, samples), dx, segment);
  for (double lower = 0.0221; lower < 2; lower *= 2) {
    Complex ab = 0;
    double aa = 0, bb = 0, expected = 0;
    int bins = 0;
    for (std::size_t k = 1; k < segment / 2; ++k) {
      const double n = static_cast<double>(k) * w.df;
      if (n < lower || n >= 2 * lower || n > 2.8) continue;
      // n^2 whitens the band, so that every bin counts alike.
      ab += w.ab[k] * n * n, aa += w.aa[k] * n * n, bb += w.bb[k] * n * n;
      expected += truth(n);
      ++bins;
    }
    expected /= bins;
    // Standard deviation of an estimated real coherence over N values: at most sqrt((1 - gamma^2) / N). Five of them,
    // and 0.005 for the
    // width of the window.
    const double values = w.segments * 0.9 * bins / 1.5;
    const double tolerance = 5 * std::sqrt((1 - expected * expected) / values) + 0.005;
    EXPECT_NEAR(ab.real() / std::sqrt(aa * bb), expected, tolerance) << "band from " << lower << " cycles/m";
    EXPECT_NEAR(ab.imag() / std::sqrt(aa * bb), 0, tolerance) << "band from " << lower << " cycles/m";
  }
}

/// Cross spectrum of an isotropic surface whose lines have the PSD n^-2, by integrating its plane spectrum (n^2 +
/// m^2)^(-3/2) over the lateral
/// wavenumber m = n tan(a).
double isotropic_by_quadrature(double n, double b) {
  const int steps = 20000;
  double sum = 0;
  // The last part of a oscillates ever faster but weighs cos(a) da.
  for (int i = 0; i < steps; ++i) {
    const double a = (i + 0.5) / steps * pi_ / 2;
    sum += std::cos(a) * std::cos(2 * pi_ * n * b * std::tan(a));
  }
  return sum * pi_ / 2 / steps;
}

TEST(IsoCoherence, FormulaIsThatOfAnIsotropicSurface) {
  Iso8608Settings p;
  p.track_width = 1.5;
  for (double n : {0.011, 0.03, 0.1, 0.2, 0.4})
    EXPECT_NEAR(iso8608_coherence(p, n), isotropic_by_quadrature(n, 1.5), 1e-4) << n;
}

TEST(IsoCoherence, IsotropicTracksCohereLikeAnIsotropicSurface) {
  expect_coherence(long_road(11), [](double n) { return isotropic_by_quadrature(n, 1.5); });
}

TEST(IsoCoherence, ExponentialTracksCohereExponentially) {
  Iso8608Settings p = long_road(12);
  p.coherence = Iso8608Settings::Coherence::exponential;
  p.decay = 3;
  expect_coherence(p, [](double n) { return std::exp(-3 * n * 1.5); });
}

TEST(IsoCoherence, FullMeansOneProfileAcross) {
  Iso8608Settings p;
  p.track_width = 1;
  p.coherence = Iso8608Settings::Coherence::full;
  const GroundPtr g = iso8608_ground(p);
  for (double x = 0; x < 20; x += 0.31) {
    EXPECT_NEAR(g->height(x, -0.5), g->height(x, 0.5), 1e-15);
    EXPECT_NEAR(g->height(x, 0.1), g->height(x, 0.5), 1e-15);
  }
}

TEST(Iso8608, SameSeedSameBitsOtherSeedOtherRoad) {
  Iso8608Settings p;
  p.track_width = 0.5;
  p.seed = 3;
  const GroundPtr a = iso8608_ground(p), b = iso8608_ground(p);
  p.seed = 4;
  const GroundPtr c = iso8608_ground(p);
  int different = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = -7 + 0.0173 * i, y = -0.4 + 0.0008 * i;
    EXPECT_EQ(a->height(x, y), b->height(x, y));
    different += a->height(x, y) != c->height(x, y);
  }
  EXPECT_EQ(different, 1000);
}

TEST(Iso8608, ClassesOfOneSeedAreOneShapeScaled) {
  Iso8608Settings p;
  p.track_width = 0.5;
  p.roughness = iso8608_roughness('A');
  const GroundPtr a = iso8608_ground(p);
  p.roughness = iso8608_roughness('C');
  const GroundPtr c = iso8608_ground(p);
  // Two classes up: PSD times 16, heights times 4.
  for (double x = 0; x < 10; x += 0.77) EXPECT_NEAR(c->height(x, 0.1), 4 * a->height(x, 0.1), 1e-12);
}

TEST(Iso8608, OneHarmonicIsACosineOfTheRightAmplitude) {
  // Band so narrow that only 0.1 cycles/m lies in it: amplitude sqrt(2 Gd / period), and the interpolation shows alone.
  Iso8608Settings p;
  p.track_width = 1;
  p.period = 100;
  p.lowest = 0.0999;
  p.highest = 0.1001;
  p.roughness = 1024e-6;
  const GroundPtr g = iso8608_ground(p);
  const double amplitude = std::sqrt(2 * 1024e-6 / 100);
  for (double y : {-0.5, 0.5}) {
    const double c = g->height(0, y), s = -g->height(2.5, y);  // amplitude times cos and sin of the phase
    EXPECT_NEAR(std::hypot(c, s), amplitude, 1e-6 * amplitude);
    for (double x = -20; x < 120; x += 0.0917) {
      const double a = 2 * pi_ * 0.1 * x;
      // Hermite between nodes 51 per wave: (2 pi/51)^4/384 = 6e-7 of the amplitude, its slope 2e-5.
      EXPECT_NEAR(g->height(x, y), c * std::cos(a) - s * std::sin(a), 1e-6 * amplitude);
      const Vec3 n = g->normal(x, y);
      EXPECT_NEAR(-n.x() / n.z(), -0.2 * pi_ * (c * std::sin(a) + s * std::cos(a)), 3e-5 * amplitude);
    }
  }
}

TEST(Iso8608, RepeatsWithItsPeriodAndHasNoJumpOrCrease) {
  Iso8608Settings p;
  p.track_width = 0.5;
  p.roughness = iso8608_roughness('E');
  p.frame = {0.5, 1, -0.2};
  p.run_in = 2;
  const GroundPtr g = iso8608_ground(p);
  for (double x = -1; x < 12; x += 0.0313) ground_test::expect_normal_is_gradient(*g, x, 0.31 * x - 1, 2e-6);
  const double c = std::cos(0.5), s = std::sin(0.5);
  for (double x = 5; x < 9; x += 0.13) EXPECT_NEAR(g->height(x, 0), g->height(x + 1000 * c, 1000 * s), 1e-10);
}

TEST(Iso8608, RunInBeginsOnFlatGround) {
  Iso8608Settings p;
  p.track_width = 0.5;
  p.run_in = 2;
  p.frame.start = 1;
  const GroundPtr g = iso8608_ground(p);
  p.run_in = 0;
  const GroundPtr bare = iso8608_ground(p);
  for (double x = -5; x <= 1; x += 0.1) EXPECT_EQ(g->height(x, 0.3), 0);
  EXPECT_NEAR(g->height(2, 0.3), 0.5 * bare->height(2, 0.3), 1e-15);
  EXPECT_EQ(g->height(3.5, 0.3), bare->height(3.5, 0.3));
}

TEST(Iso8608, RefusesSettingsOutOfRange) {
  EXPECT_THROW(iso8608_roughness('I'), GroundError);
  Iso8608Settings good;
  good.track_width = 1;
  auto refused = [&](auto change) {
    Iso8608Settings p = good;
    change(p);
    EXPECT_THROW(iso8608_ground(p), GroundError);
  };
  refused([](auto& p) { p.track_width = 0; });
  refused([](auto& p) { p.roughness = -1; });
  refused([](auto& p) { p.waviness = 0.5; });
  refused([](auto& p) { p.period = 100; });
  refused([](auto& p) { p.period = 1e6; });
  refused([](auto& p) { p.highest = p.lowest; });
  refused([](auto& p) { p.run_in = NAN; });
}

}  // namespace
}  // namespace grouser
