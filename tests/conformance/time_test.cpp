// Steps, threads, previews and refusals.
#include "conformance/conformance.h"

namespace grouser::test {
namespace {

class Time : public Conformance {};

TEST_P(Time, ImpulseDoesNotDependOnTheSplitOfTheStep) {
  GROUSER_NOT_FOR_GRAINS("another split is another inner step, and collisions are chaotic: only the mean converges");
  // 0.1 s of smooth motion in contact, split into 64 to 1024 steps: the total impulse converges with first order or
  // better. The observed order comes from three splits each; 0.8 leaves room for terms of second order. Rows over cells (sdem.v2:rows)
  // read the soil anew at each step, a little flatter each time: it converges, with an order of 0.3 at least.
  const double order = GetParam() == "sdem.v2:rows" ? 0.3 : 0.8;
  const RandomMotion shake(7, {0.003, 0.002, 0.003, 0.05, 0.1}, 0.4);
  auto total = [&](int n) {
    const auto t = make();
    Vec6 sum = Vec6::Zero();
    const double dt = 0.1 / n;
    auto at = [&](double time) { return shake.at(time, Rolling{0.012, 0.1, 0.2, 0.05}.at(time)); };
    for (int i = 0; i < n; ++i) {
      const BodyResult r = step_one(*t, i * dt, dt, motion(at(i * dt), at((i + 1) * dt)));
      sum.head<3>() += r.impulse;
      sum.tail<3>() += r.angular_impulse / radius();
    }
    return sum;
  };
  std::vector<Vec6> sums;
  for (int n = 64; n <= 1024; n *= 2) sums.push_back(total(n));
  for (std::size_t i = 0; i + 2 < sums.size(); ++i) {
    const double coarse = (sums[i + 1] - sums[i]).norm(), fine = (sums[i + 2] - sums[i + 1]).norm();
    EXPECT_GT(std::log2(coarse / fine), order) << "split " << (64 << i);
  }
  // At 1 ms (the usual host step) the split changes the impulse by less than 1 %.
  EXPECT_LE((sums[1] - sums[0]).norm(), 0.01 * sums.back().norm());
}

/// Six wheels on rough ground.
State drive_six(Terrain& t, int first, int last, std::vector<BodyResult>* results = nullptr) {
  const double dt = 1e-3;
  std::vector<BodyMotion> m(6);
  std::vector<BodyResult> r(6);
  static const RandomMotion shake(3, {0.01, 0.01, 0.006, 0.1, 0.3}, 0.3);
  for (int i = first; i < last; ++i) {
    for (int k = 0; k < 6; ++k) {
      auto at = [&](double time) {
        WheelState s = shake.at(time + 0.05 * k, Rolling{0.006, 0.3, 0.1 * k, 0.02 * k}.at(time));
        s.hub += Vec3(0.3 * (k / 2), 0.4 * (k % 2), 0);
        return s;
      };
      m[static_cast<std::size_t>(k)] = motion(at(i * dt), at((i + 1) * dt));
    }
    t.step(i * dt, dt, m, r);
    if (results) results->insert(results->end(), r.begin(), r.end());
  }
  return state_of(t);
}

void expect_same(const std::vector<BodyResult>& a, const std::vector<BodyResult>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].impulse, b[i].impulse) << i;
    ASSERT_EQ(a[i].angular_impulse, b[i].angular_impulse) << i;
    ASSERT_EQ(a[i].report.sinkage, b[i].report.sinkage) << i;
    ASSERT_EQ(a[i].linearisation.has_value(), b[i].linearisation.has_value());
    if (a[i].linearisation) {
      ASSERT_EQ(a[i].linearisation->dF_dx, b[i].linearisation->dF_dx) << i;
    }
  }
}

TEST_P(Time, NumberOfThreadsDoesNotChangeABit) {
  std::vector<BodyResult> one;
  const auto t = make(std::make_shared<Waves>(0.003, 0.2), 6);
  const State reference = drive_six(*t, 0, 200, &one);
  for (const int threads : {2, 4}) {
    const auto other = make(std::make_shared<Waves>(0.003, 0.2), 6);
    other->set_threads(threads);
    std::vector<BodyResult> many;
    const State s = drive_six(*other, 0, 200, &many);
    EXPECT_EQ(s.hash(), reference.hash()) << threads << " threads";
    expect_same(one, many);
  }
}

TEST_P(Time, SavedAndLoadedRunContinuesBitByBit) {
  const GroundPtr ground = std::make_shared<Waves>(0.003, 0.2);
  const auto whole = make(ground, 6), first = make(ground, 6), second = make(ground, 6);
  std::vector<BodyResult> a, b;
  const State end = drive_six(*whole, 0, 200, &a);
  for (const ModelInfo& m : tested_models().models()) ASSERT_FALSE(m.id.empty());
  State saved = drive_six(*first, 0, 113, &b);
  saved.rewind(State::Mode::load);
  second->traverse(saved);
  saved.finish();
  const auto d = State::first_difference(saved, state_of(*second));
  ASSERT_FALSE(d) << d->field << ": " << d->left << " became " << d->right;
  const State continued = drive_six(*second, 113, 200, &b);
  const auto e = State::first_difference(end, continued);
  EXPECT_FALSE(e) << e->field << ": " << e->left << " became " << e->right;
  expect_same(a, b);
}

TEST_P(Time, SameInputGivesTheSameBits) {
  const GroundPtr ground = std::make_shared<Waves>(0.003, 0.2);
  const auto a = make(ground, 6), b = make(ground, 6);
  EXPECT_EQ(drive_six(*a, 0, 100).hash(), drive_six(*b, 0, 100).hash());
}

TEST_P(Time, PreviewAnswersLikeTheStepAndChangesNothing) {
  const auto t = make(std::make_shared<Waves>(0.003, 0.2));
  for (int i = 0; i < 100; ++i) {
    const Rolling rolling{0.006, 0.3, 0.3, 0.1};
    const BodyMotion m = motion(rolling.at(1e-3 * i), rolling.at(1e-3 * (i + 1)));
    BodyMotion elsewhere = m;
    elsewhere.X_WB_end.p.z() -= 0.003;
    elsewhere.V_WB_end.v.x() = -0.4;
    const std::uint64_t before = state_of(*t).hash();
    preview_one(*t, 1e-3 * i, 1e-3, elsewhere);
    const BodyResult p = preview_one(*t, 1e-3 * i, 1e-3, m);
    ASSERT_EQ(state_of(*t).hash(), before) << "step " << i;
    const BodyResult s = step_one(*t, 1e-3 * i, 1e-3, m);
    expect_same({p}, {s});
  }
}

TEST_P(Time, WrongCallsAreRefusedAndLeaveTheStateAlone) {
  const auto t = make();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 5; ++i) step_one(*t, 1e-3 * i, 1e-3, arriving(Rolling{}.at(1e-3 * (i + 1)), 1e-3));
  const std::uint64_t before = state_of(*t).hash();
  const BodyMotion good = arriving(Rolling{}.at(6e-3), 1e-3);
  EXPECT_THROW(step_one(*t, 5e-3, 0, good), TerrainError);
  EXPECT_THROW(step_one(*t, 5e-3, -1e-3, good), TerrainError);
  EXPECT_THROW(step_one(*t, 5e-3, nan, good), TerrainError);
  EXPECT_THROW(step_one(*t, 4e-3, 1e-3, good), TerrainError) << "time running back";
  EXPECT_THROW(step_one(*t, 7e-3, 1e-3, good), TerrainError) << "a gap in time";
  BodyMotion bad = good;
  bad.X_WB_end.p.x() = nan;
  EXPECT_THROW(step_one(*t, 5e-3, 1e-3, bad), TerrainError);
  bad = good;
  bad.V_WB_end.w.y() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(step_one(*t, 5e-3, 1e-3, bad), TerrainError);
  bad = good;
  bad.X_WB_end.q = Quat(0, 0, 0, 0);
  EXPECT_THROW(step_one(*t, 5e-3, 1e-3, bad), TerrainError);
  std::vector<BodyMotion> two{good, good};
  std::vector<BodyResult> r(2);
  EXPECT_THROW(t->step(5e-3, 1e-3, two, r), TerrainError);
  EXPECT_THROW(t->add_body({"late", gear(), {}}), TerrainError);
  EXPECT_EQ(state_of(*t).hash(), before);
  EXPECT_NO_THROW(step_one(*t, 5e-3, 1e-3, good));
}

TEST_P(Time, EffectsStayWithinTheirBoundsAndBelongToTheState) {
  const auto t = make();
  EXPECT_THROW(t->set_effect("no such effect", 1), TerrainError);
  for (const Effect& e : t->effects()) {
    EXPECT_FALSE(e.description.empty()) << e.id;
    EXPECT_FALSE(e.unit.empty()) << e.id;
    EXPECT_FALSE(e.citation.empty()) << e.id;
    EXPECT_LT(e.lower, e.upper) << e.id;
    EXPECT_THROW(t->set_effect(e.id, e.upper + 1), TerrainError);
    EXPECT_THROW(t->set_effect(e.id, std::nan("")), TerrainError);
    const std::uint64_t before = state_of(*t).hash();
    t->set_effect(e.id, e.lower + 0.6 * (e.upper - e.lower));  // the middle may be zero
    EXPECT_NE(state_of(*t).hash(), before) << e.id;
  }
}

TEST_P(Time, SurfaceStartsAsTheGround) {
  const auto t = make(std::make_shared<Waves>(0.003, 0.2));
  for (double x = -1; x < 1; x += 0.13) {
    const SurfaceSample s = t->surface(x, 0.1);
    EXPECT_NEAR(s.height, t->ground().height(x, 0.1), 1e-12);
    EXPECT_NEAR(s.normal.norm(), 1, 1e-12);
    EXPECT_GT(s.normal.z(), 0);
    EXPECT_EQ(s.sinkage, 0);
  }
}

GROUSER_EVERY_MODEL(Time);

}  // namespace
}  // namespace grouser::test
