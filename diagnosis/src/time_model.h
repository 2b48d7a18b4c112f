#pragma once
// Accounts of a series, their fit and their evidence.
#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "grouser/diagnosis/time_series.h"
#include "run_model.h"
#include "time_lag.h"

namespace grouser::diagnosis {

/// What an account without a name lets go free.
enum class TimeExtra {
  none,
  shape_time,    ///< the response to a change: four fixed lags in time, any weights
  shape_travel,  ///< the same over travel
  drift,         ///< every channel drifts with time, three terms
  levels,        ///< every channel's steady level is off by a curve of slip, three terms
};

struct TimeAccount {
  std::array<bool, time_effect_count> on{};
  TimeExtra extra = TimeExtra::none;
  bool has(TimeEffect e) const { return on[static_cast<std::size_t>(e)]; }
  int effects() const;
  std::string id() const;  ///< "filter", "delay+ripple", "none", "relaxation_length and a response of another shape"
};

/// One fitted number: its prior N(mean, sd) in the fitted coordinate, and bounds.
struct TimeParameter {
  std::string name;
  double mean = 0, sd = 1, lower = 0, upper = 0;
};

struct TimeFit {
  bool ok = false;
  Eigen::VectorXd x;
  std::array<TimeNoise, channel_count> noise{};
  double chi2 = 0, penalty = 0;
  double log_likelihood =
      0;  ///< with the noise as found, without constants; less half of `penalty` and the noise's prior
  double log_evidence = 0;  ///< Laplace
  Eigen::MatrixXd covariance;
  RowMatrix predicted;  ///< rows of all runs by channels
};

class TimeModel {
 public:
  TimeModel(const TimeCase& c, std::vector<TimeRun> runs, const std::array<bool, channel_count>& measured,
            const std::array<bool, channel_count>& stated_sd);

  const std::vector<TimeRun>& runs() const { return runs_; }
  const std::vector<int>& channels() const { return channels_; }
  const TimeCase& given() const { return case_; }
  int rows() const { return row_count_; }
  double sd(int row, int channel) const { return sd_(row, channel); }
  double spacing() const { return spacing_; }
  double speed() const { return speed_; }
  int soil_parameters() const { return static_cast<int>(soil_.size()); }
  const std::vector<int>& free_soil() const { return soil_; }

  std::vector<TimeParameter> parameters(const TimeAccount& a) const;
  Eigen::VectorXd start(const TimeAccount& a) const;  ///< prior means
  /// Index of ln sigma, ln tau, ln delay in an account's parameters; of ripple's first amplitude. -1 where it is off.
  int index_of(const TimeAccount& a, TimeEffect e) const;
  /// Parameters of `from` that `to` has as well, the others at their prior mean; free shapes, drifts and levels begin at 0.
  Eigen::VectorXd carried(const TimeAccount& from, const Eigen::VectorXd& x, const TimeAccount& to) const;

  /// Rows of all runs by channels; slopes: (row * channels + channel) by parameters. False: no answer.
  bool predict(const TimeAccount& a, const Eigen::VectorXd& x, RowMatrix& y, Eigen::MatrixXd* slopes) const;
  /// -2 ln likelihood and prior at x for this noise, up to constants.
  double objective(const TimeAccount& a, const Eigen::VectorXd& x,
                   const std::array<TimeNoise, channel_count>& noise) const;
  /// Ceres (Levenberg-Marquardt) for given noise, then the noise from what is left, in turn until both stand.
  TimeFit fit(const TimeAccount& a, Eigen::VectorXd x, std::array<TimeNoise, channel_count> noise,
              int rounds = 4) const;
  /// Best of several starts of the dynamics; `base`: a fit of an account that `a` contains.
  TimeFit search(const TimeAccount& a, const TimeAccount& base, const TimeFit& from) const;

  /// Residuals into independent ones of size 1, and -2 ln of the volume.
  void whiten(Eigen::MatrixXd& columns, const std::array<TimeNoise, channel_count>& noise) const;
  double log_determinant(const std::array<TimeNoise, channel_count>& noise) const;
  const Eigen::VectorXd& measured() const { return y_; }  ///< item by item
  /// Items: measured values, run by run, channel by channel, by time.
  struct Item {
    int run, row, channel;  ///< row over all runs; channel: place in channels()
    double sd, gap;         ///< gap: time since the item before of this run and channel, in spacings; 0 for the first
  };
  const std::vector<Item>& items() const { return items_; }
  Eigen::VectorXd item_values(const RowMatrix& y) const;
  std::array<TimeNoise, channel_count> noise_of(const Eigen::VectorXd& residual, double free_parameters) const;
  double noise_penalty(const std::array<TimeNoise, channel_count>& noise) const;

 private:
  friend class TimeCost;
  struct Layout {
    int soil = 0, scatter = 0, start = 0, dynamics = 0, extra = 0, size = 0;  ///< first of each part
  };
  Layout layout(const TimeAccount& a) const;
  bool targets(const Eigen::VectorXd& x, const Layout& l, bool slopes) const;
  TimeDynamics dynamics(const TimeAccount& a, const Eigen::VectorXd& x) const;
  int extras(const TimeAccount& a) const;

  TimeCase case_;
  std::vector<TimeRun> runs_;
  std::vector<int> channels_, soil_, scattered_;
  std::array<bool, channel_count> stated_{};
  std::vector<int> first_row_;
  int row_count_ = 0;
  double spacing_ = 1, speed_ = 1, duration_ = 1;
  Eigen::MatrixXd sd_;  ///< rows by place in channels()
  std::vector<Item> items_;
  Eigen::VectorXd y_;
  std::vector<TimeTrack> tracks_;  ///< without targets
  /// Knots of all runs: the rows, and moments between them where slip or load moves so far that the steady answer is no straight line.
  std::vector<Run> knots_;
  std::vector<int> first_knot_;
  // Steady answers of the last soil, which grids and line searches ask for again.
  mutable Eigen::VectorXd cached_soil_;
  mutable bool cached_slopes_ = false;
  mutable std::vector<double> theta_;
  mutable std::vector<Outputs> steady_;
  mutable std::vector<Slopes> steady_slopes_;
};

}  // namespace grouser::diagnosis
