// Which contact law made the curves: an emulator of stored runs, evidence, verdicts. The truth is a soil of formulas
// written here, not grains.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "../../diagnosis/src/emulator.h"
#include "../../diagnosis/src/soil_test_fit.h"
#include "grouser/diagnosis/soil_test_diagnosis.h"
#include "grouser/terrain/config.h"

namespace grouser::diagnosis {
namespace {

namespace fs = std::filesystem;

/// A soil of formulas: stress in a window of displacement.
struct Toy {
  double Y = 5e7, mu = 0.6, roll = 0.2;  ///< roll: constant, or c of the rate law
  bool rate = false;
  double cohesion = 0, wall = 0, size = 1;
};
double rolling_at(const Toy& s, double speed) { return s.rate ? 0.06 * std::pow(s.roll * speed * speed, 0.2) : s.roll; }
double stress(const Toy& s, bool shear, double p, double speed, int window) {
  const double r = rolling_at(s, speed), w = window;
  if (shear)
    return p * std::pow(s.mu, 0.7) * std::pow(r, 0.1 + 0.12 * w) * (0.9 + 0.3 * w) * (1 + s.cohesion / 6e5 * 2000 / p) *
           (1 + 0.5 * s.wall * w) * std::pow(s.size, -0.4 * w);
  return 2e4 * (1 + w) * std::pow(s.mu, 1.1) * std::pow(r, 0.7) * std::pow(s.Y / 5e7, 0.05) *
         (1 + 0.4 * s.cohesion / 6e5) * (1 + 0.8 * s.wall) * std::pow(s.size, 1.1);
}
constexpr double kMiddle[2][3] = {{2.5, 5.0, 8.0}, {1.0, 2.25, 4.5}};

class GrainDiagnosis : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("grouser-grain-diagnosis-" + std::to_string(::getpid()));
    fs::create_directories(folder);
    std::ofstream out(folder / "stored.csv");
    out << "run,test,rolling_law,young_modulus_Pa,friction,rolling,normal_stress_Pa,effect,amount,seed,inputs_hash,"
           "rise_mm";
    for (int k = 0; k < 20; ++k) out << ",stress_Pa_at_" << 0.25 + 0.5 * k << "_mm";
    out << "\n";
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> u;
    std::normal_distribution<double> noise(0, 0.05);
    const auto spread = [&](double a, double b) { return a * std::pow(b / a, u(random)); };
    int number = 0;
    const auto block = [&](bool rate, const std::string& effect, bool shear, int count) {
      for (int i = 0; i < count; ++i) {
        Toy s;
        s.rate = rate, s.Y = spread(2e7, 1.2e8), s.mu = spread(0.3, 1);
        const double speed = shear ? 6.6e-3 : 0.05;
        const double A = rate ? (shear ? spread(0.1, 3e6) : spread(100, 3e6)) : 0;
        s.roll = rate ? A / speed / speed : spread(0.02, 1);
        double amount = 0;
        if (effect == "cohesion") amount = s.cohesion = 6e5 * u(random);
        if (effect == "wall_effects") amount = s.wall = 0.6 * u(random);
        if (effect == "grain_size") amount = s.size = spread(0.8, 1.3);
        const double p = shear ? spread(1500, 25000) : 0, common = noise(random);
        out << "r" << ++number << "," << (shear ? "shear" : "plate") << "," << (rate ? "rate" : "constant") << ","
            << s.Y << "," << s.mu << "," << (rate ? A : s.roll) << "," << p << "," << effect << "," << amount << ",1,x,"
            << (shear ? "0.5" : "");
        double factor[3];
        for (double& f : factor) f = std::exp(common + noise(random));
        for (int k = 0; k < 20; ++k) {
          const double d = 0.25 + 0.5 * k;
          const int w = shear ? (d < 1.5 ? 0 : d < 3 ? 1 : 2) : (d < 3.75 ? 0 : d < 6.25 ? 1 : 2);
          out << ",";
          if (!shear || d < 6) out << stress(s, shear, p, speed, w) * factor[w];
        }
        out << "\n";
      }
    };
    for (const bool shear : {true, false}) {
      block(false, "", shear, shear ? 80 : 40);
      block(true, "", shear, shear ? 80 : 40);
      for (const char* e : {"cohesion", "wall_effects", "grain_size"}) block(false, e, shear, shear ? 30 : 16);
    }
    out.close();
    std::ofstream(folder / "case.yaml") << "model: dem.soil_tests\nstored_runs: stored.csv\nsoil:\n"
                                           "  young_modulus: {value: 50 MPa, ln_sd: 0.4}\n"
                                           "  friction: {value: 0.6, ln_sd: 0.12}\n"
                                           "  rolling_coefficient: {value: 0.2, ln_sd: 0.8}\n";
  }
  void TearDown() override { fs::remove_all(folder); }

  /// Curves of a soil: three pressures at 0.66 mm/s and a plate at 10 mm/s. `change`: something else that happens to
  /// the stress.
  fs::path curves(const Toy& s, unsigned seed, int repeats = 4,
                  const std::function<double(bool shear, double p, int window)>& change = {}) {
    const fs::path file = folder / ("curves" + std::to_string(seed) + ".csv");
    std::ofstream out(file);
    out << "test,normal_stress_Pa,speed_mm_s,rest_s,repeat,displacement_mm,stress_Pa\n";
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, 0.05);
    for (int r = 0; r < repeats; ++r)
      for (const double p : {2080.0, 5330.0, 17830.0, 0.0}) {
        const bool shear = p > 0;
        const double common = noise(random);
        double factor[3];
        for (double& f : factor) f = std::exp(common + noise(random));
        for (int k = 0; k < (shear ? 24 : 40); ++k) {
          const double d = 0.125 + 0.25 * k;
          const int w = shear ? (d < 1.5 ? 0 : d < 3 ? 1 : 2) : (d < 3.75 ? 0 : d < 6.25 ? 1 : 2);
          const double more = change ? change(shear, p, w) : 1;
          out << (shear ? "shear" : "plate") << "," << p << "," << (shear ? 0.66 : 10) << "," << (shear ? "1" : "0")
              << "," << r << "," << d << "," << stress(s, shear, p, shear ? 6.6e-4 : 0.01, w) * factor[w] * more
              << "\n";
        }
      }
    return file;
  }
  SoilTestDiagnosis diagnosed(const fs::path& file, const std::vector<std::string>& withhold = {}) {
    return diagnose_soil_tests(read_soil_test_case(folder / "case.yaml"), read_soil_test_curves(file), withhold);
  }
  std::string errors_of(const std::function<void()>& f) {
    try {
      f();
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "";
  }
  fs::path folder;
};

TEST(Emulator, FindsAQuadraticExactlyAndRefusesToExtrapolate) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto f = [](double a, double b) { return 2 + a - 0.5 * b + 0.3 * a * b + 0.7 * b * b; };
  Eigen::MatrixXd x(20, 2), y(20, 2);
  for (int i = 0; i < 20; ++i) {
    x(i, 0) = u(random), x(i, 1) = 5 + 3 * u(random);
    y(i, 0) = f(x(i, 0), x(i, 1)), y(i, 1) = x(i, 1);
  }
  const Emulator e({{"a", -1, 1, 0, 1}, {"b", 2, 8, 5, 3}}, polynomial_terms(2, {0, 1}, 2), x, y);
  const Eigen::VectorXd at = Eigen::Vector2d(0.3, 6.1);
  EXPECT_NEAR(e.mean(e.features(at))[0], f(0.3, 6.1), 1e-11);
  EXPECT_NEAR(e.mean(e.features(at))[1], 6.1, 1e-11);
  EXPECT_TRUE(e.inside(at));
  EXPECT_FALSE(e.inside(Eigen::Vector2d(0.3, 8.5)));
}

TEST(Emulator, ErrorsLeftOutAreThoseOfRefitsWithoutTheRun) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> n;
  Eigen::MatrixXd x(25, 2), y(25, 1);
  for (int i = 0; i < 25; ++i)
    x(i, 0) = n(random), x(i, 1) = n(random), y(i, 0) = std::sin(x(i, 0)) + x(i, 1) + 0.2 * n(random);
  const auto terms = polynomial_terms(2, {0, 1}, 2);
  const std::vector<Emulator::Input> inputs{{"a", -9, 9, 0, 1}, {"b", -9, 9, 0, 1}};
  const Emulator all(inputs, terms, x, y);
  for (const int left : {0, 7, 24}) {
    Eigen::MatrixXd xs(24, 2), ys(24, 1);
    for (int i = 0, k = 0; i < 25; ++i)
      if (i != left) xs.row(k) = x.row(i), ys.row(k++) = y.row(i);
    const Emulator rest(inputs, terms, xs, ys);
    EXPECT_NEAR(all.left_out()(left, 0), y(left, 0) - rest.mean(rest.features(x.row(left)))[0], 1e-9);
  }
}

TEST(Emulator, SaysHowFarItsMeanScattersOverNoisySets) {
  // 2000 sets of noise on the same runs: standard error of a variance of 2000 draws is 3 %.
  std::mt19937_64 random(5);
  std::normal_distribution<double> n;
  Eigen::MatrixXd x(15, 1);
  for (int i = 0; i < 15; ++i) x(i, 0) = n(random);
  const auto terms = polynomial_terms(1, {0}, 2);
  const std::vector<Emulator::Input> inputs{{"a", -9, 9, 0, 1}};
  double squares = 0, share = 0, scatter = 0;
  for (int k = 0; k < 2000; ++k) {
    Eigen::MatrixXd y(15, 1);
    for (int i = 0; i < 15; ++i) y(i, 0) = 1 + x(i, 0) + 0.3 * n(random);
    const Emulator e(inputs, terms, x, y);
    const Eigen::VectorXd h = e.features(Eigen::VectorXd::Constant(1, 0.7));
    squares += std::pow(e.mean(h)[0] - 1.7, 2), share = e.share(h, h), scatter += e.scatter()(0, 0) / 2000;
  }
  EXPECT_NEAR(squares / 2000, share * 0.09, 0.12 * share * 0.09);
  EXPECT_NEAR(scatter, 0.09, 0.003);
}

TEST_F(GrainDiagnosis, NamesRollingBySpeedWhenConstantRollingCannotDoBothTests) {
  Toy s;
  s.rate = true, s.roll = 6.75e8;
  const SoilTestDiagnosis d = diagnosed(curves(s, 1));
  EXPECT_EQ(d.verdict, "named") << d.sentence;
  EXPECT_EQ(d.cause, "rolling_rate_dependence");
  EXPECT_EQ(d.law, "rate");
  EXPECT_LT(d.extended_rmse, d.nominal_rmse);
}

TEST_F(GrainDiagnosis, ClearsTheNominalLawInMostSetsThatItMade) {
  // Six sets: with false alarms in a twentieth of them, two or more would come up once in thirty times; the seeds are
  // fixed.
  int alarms = 0;
  for (unsigned k = 0; k < 6; ++k) {
    Toy s;
    s.mu = 0.6 * std::exp(0.06 * (k % 3 - 1.0)), s.roll = 0.12 + 0.03 * k;
    alarms += diagnosed(curves(s, 100 + k)).verdict != "adequate";
  }
  EXPECT_LE(alarms, 1);
}

TEST_F(GrainDiagnosis, CallsAShiftOfFrictionAParameter) {
  Toy s;
  s.mu = 0.36;  // 4.3 prior sd
  const SoilTestDiagnosis d = diagnosed(curves(s, 5));
  EXPECT_EQ(d.verdict, "parameter") << d.sentence;
  EXPECT_LT(d.nominal.at("friction").prior_z, -3);
}

TEST_F(GrainDiagnosis, SaysUnknownWhenNothingOnTheListDoesIt) {
  // Shear strength that falls to a half beyond 3 mm, plates untouched: no law, wall, size or cohesion does that.
  const SoilTestDiagnosis d =
      diagnosed(curves({}, 6, 4, [](bool shear, double, int w) { return shear && w == 2 ? 0.4 : 1.0; }));
  EXPECT_EQ(d.verdict, "unknown") << d.sentence;
}

TEST_F(GrainDiagnosis, GainIsMeasuredOnCurvesThatWereNotFitted) {
  Toy s;
  s.rate = true, s.roll = 6.75e8;
  const SoilTestDiagnosis d = diagnosed(curves(s, 8), {"normal_stress_Pa=17830"});
  ASSERT_TRUE(d.gain.has_value());
  EXPECT_EQ(d.gain->runs, 4);
  for (const SoilTestFigures& f : d.figures) EXPECT_NE(f.condition.normal_stress, 17830);
}

TEST_F(GrainDiagnosis, AnAmountOfZeroIsTheNominalLawToTheBit) {
  const SoilTestCase c = read_soil_test_case(folder / "case.yaml");
  const SoilTestData data = read_soil_test_curves(curves({}, 9));
  const SoilTestModel model(c.stored, data.rise);
  const SoilTestFits fits(model, c, data.conditions, data.rise);
  const auto accounts = fits.accounts();
  const Eigen::VectorXd soil = Eigen::Vector3d(std::log(4e7), std::log(0.7), std::log(0.1));
  for (const SoilTestAccount& a : accounts) {
    if (!a.named || a.law == RollingLaw::rate) continue;
    Eigen::VectorXd x(4);
    x << soil, 0.0;
    for (const SoilTestCondition& k : data.conditions)
      for (Eigen::Index i = 0; i < 3; ++i)
        EXPECT_EQ(fits.predict(a, x, k)[i], fits.predict(accounts[0], soil, k)[i]) << a.id;
  }
}

TEST_F(GrainDiagnosis, EvidenceIsTheMeanLikelihoodOverThePrior) {
  // Plain sampling of the prior, by other code: 60,000 draws, error of the logarithm about 0.1 (few draws fall where
  // the data are).
  const SoilTestCase c = read_soil_test_case(folder / "case.yaml");
  SoilTestData data = read_soil_test_curves(curves({}, 10, 1));
  data.conditions.erase(data.conditions.begin() + 1, data.conditions.begin() + 3);  // one shear test and the plate
  const SoilTestModel model(c.stored, data.rise);
  const SoilTestFits fits(model, c, data.conditions, data.rise);
  const SoilTestAccount none = fits.accounts()[0];
  const SoilTestPosterior p = fits.posterior(none);
  ASSERT_TRUE(p.ok);
  std::mt19937_64 random(12);
  std::normal_distribution<double> n;
  double top = -INFINITY, sum = 0;
  std::vector<double> all;
  while (all.size() < 60000) {
    Eigen::VectorXd x(3);
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      const SoilTestCoordinate& k = none.coordinates[static_cast<std::size_t>(i)];
      x[i] = k.mean + k.sd * n(random);
      inside = inside && x[i] > k.lower && x[i] < k.upper;
    }
    if (!inside) continue;
    // The likelihood of two independent groups, written out: each condition against its own mean and covariance.
    double ln_l = 0;
    for (const SoilTestValues& v : fits.values()) {
      Eigen::MatrixXd error;
      const Eigen::VectorXd r = v.mean - fits.predict(none, x, v.condition, &error);
      const Eigen::MatrixXd C = error + fits.repeat_scatter(v.condition.kind) + fits.fixed_scatter(v.condition.kind);
      ln_l -= 0.5 * (r.dot(C.inverse() * r) + std::log(C.determinant()) + 3 * std::log(2 * M_PI));
    }
    all.push_back(ln_l);
    top = std::max(top, ln_l);
  }
  for (const double l : all) sum += std::exp(l - top);
  EXPECT_NEAR(p.ln_evidence, top + std::log(sum / 60000), 0.1);
}

TEST_F(GrainDiagnosis, MistakesInCurvesAreNamedWithTheirPlace) {
  const auto error_of = [&](const std::string& text) {
    std::ofstream(folder / "bad.csv") << text;
    return errors_of([&] { read_soil_test_curves(folder / "bad.csv"); });
  };
  EXPECT_NE(error_of("test,speed_mm_s,displacement,stress_Pa\n").find("has no unit in its name"), std::string::npos);
  EXPECT_NE(error_of("test,speed_mm_s,displacement_mm,stress_kg\n").find("'kg' is not a unit of stress"),
            std::string::npos);
  const std::string head = "test,normal_stress_Pa,speed_mm_s,rest_s,displacement_mm,stress_kPa\n";
  EXPECT_NE(error_of(head + "sheer,5000,0.66,1,1,2\n").find("bad.csv:2:1: 'sheer' is no test"), std::string::npos);
  EXPECT_NE(error_of(head + "shear,5000,0.66,1,1,nan\n").find("bad.csv:2:21"), std::string::npos);
  EXPECT_NE(error_of(head + "shear,5000,0.66,50,1,2\n").find("the stored runs rest for 0.66 mm"), std::string::npos);
  EXPECT_NE(error_of(head + "shear,5000,0.66,1,1,2\nshear,5000,0.66,1,1,2\n").find("displacement does not grow"),
            std::string::npos);
  EXPECT_NE(error_of(head + "shear,5000,0.66,1,1,2\nshear,5000,0.66,1,2,3\n").find("at least two points"),
            std::string::npos);
}

TEST_F(GrainDiagnosis, MistakesInTheCaseAreNamed) {
  std::ofstream(folder / "bad.yaml")
      << "model: dem.soil_tests\nstored_runs: nowhere.csv\nsoil:\n  young_modulus: {value: 50, ln_sd: 0.4}\n"
         "  friction: {value: 0.6, ln_sd: 0.12}\n  rolling_coefficient: {value: 0.2, ln_sd: 0.8}\n"
         "effects: [cohesoin]\n";
  const std::string e = errors_of([&] { read_soil_test_case(folder / "bad.yaml"); });
  EXPECT_NE(e.find("nowhere.csv"), std::string::npos);
  EXPECT_NE(e.find("young_modulus"), std::string::npos);
  EXPECT_NE(e.find("did you mean 'cohesion'"), std::string::npos);
}

}  // namespace
}  // namespace grouser::diagnosis
