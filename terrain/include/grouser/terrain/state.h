#pragma once
// One state traversal serves save, restore, hash and comparison.
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "grouser/terrain/types.h"

namespace grouser {

class StateStream;

/// State that does not fit the object that reads it (other names, types or sizes): names the first field that differs.
struct StateError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Ordered list of named arrays. An object with state writes one function
///
///   void MyModel::traverse(State& s) { s.field("sinkage", sinkage_); auto g = s.group("wheel"); s.field("u", u_); }
///
/// and `State` does the rest: in mode `save` the fields are appended, in mode `load` they are read back in the same order.
/// Values are kept bit by bit: save, load, continue is bit-equal. Vectors are resized on load.
class State {
 public:
  enum class Mode { save, load };
  enum class Kind : std::uint8_t { real, integer, byte };
  struct Field {
    std::string name;
    Kind kind;
    std::vector<double> real;
    std::vector<std::int64_t> integer;
    std::vector<std::uint8_t> byte;
    std::size_t size() const;
  };
  struct Difference {
    std::string field;
    std::size_t index;
    std::string left, right;
  };

  explicit State(Mode mode = Mode::save) : mode_(mode) {}

  bool loading() const { return mode_ == Mode::load; }
  /// Start reading from the first field. @throws StateError when a field was left unread by an earlier `load`.
  void rewind(Mode mode);
  /// In mode load: @throws StateError when fields remain unread.
  void finish() const;

  void field(std::string_view name, double& x) { reals(name, &x, 1); }
  void field(std::string_view name, bool& x);
  void field(std::string_view name, std::string& x);
  void field(std::string_view name, Quat& x) { reals(name, x.coeffs().data(), 4); }
  void field(std::string_view name, Pose& x);
  void field(std::string_view name, Twist& x);
  void field(std::string_view name, std::vector<double>& x);
  void field(std::string_view name, std::vector<std::int64_t>& x);
  void field(std::string_view name, std::vector<std::uint8_t>& x);
  template <class T>
  requires(std::is_integral_v<T> || std::is_enum_v<T>) void field(std::string_view name, T& x) {
    auto i = static_cast<std::int64_t>(x);
    integers(name, &i, 1);
    x = static_cast<T>(i);
  }
  template <int R, int C, int O>
  void field(std::string_view name, Eigen::Matrix<double, R, C, O>& x) {
    static_assert(R > 0 && C > 0, "fixed-size matrices only");
    reals(name, x.data(), static_cast<std::size_t>(R) * C);
  }
  void reals(std::string_view name, double* x, std::size_t n);
  void integers(std::string_view name, std::int64_t* x, std::size_t n);

  /// Prefix "name/" on every field until the returned guard dies.
  class Group {
   public:
    Group(State& s, std::string_view name);
    ~Group();
    Group(const Group&) = delete;

   private:
    State& s_;
    std::size_t old_;
  };
  [[nodiscard]] Group group(std::string_view name) { return Group(*this, name); }

  const std::vector<Field>& fields() const { return fields_; }
  void append(Field f) { fields_.push_back(std::move(f)); }

  /// 64-bit FNV-1a over names, kinds, sizes and bits; -0.0 and NaN payloads count as they are.
  std::uint64_t hash() const;
  std::string hash_text() const;  ///< 16 hexadecimal digits
  /// First value that differs in bits, or a missing field; nullopt when equal.
  static std::optional<Difference> first_difference(const State& a, const State& b);

 private:
  friend class StateStream;
  /// The stream that takes the fields, where there is one. It is of this object alone: copies keep their fields.
  struct Taker {
    StateStream* stream = nullptr;
    Taker() = default;
    Taker(const Taker&) {}
    Taker& operator=(const Taker&) { return *this; }
  };

  Field& next(std::string_view name, Kind kind);
  Taker taker_;
  Mode mode_;
  std::string prefix_;
  std::size_t cursor_ = 0;
  std::vector<Field> fields_;
};

}  // namespace grouser
