#include "grouser/terrain/state.h"

#include <bit>
#include <cstdio>
#include <cstring>

#include "grouser/terrain/state_stream.h"

namespace grouser {

namespace {
/// 64-bit FNV-1a.
constexpr std::uint64_t hash_begin = 1469598103934665603ull;

void mix(std::uint64_t& h, const void* p, std::size_t n) {
  const auto* b = static_cast<const unsigned char*>(p);
  for (std::size_t i = 0; i < n; ++i) h = (h ^ b[i]) * 1099511628211ull;
}
void mix(std::uint64_t& h, const State::Field& f) {
  const std::uint64_t n = f.size();
  mix(h, f.name.data(), f.name.size());
  mix(h, &f.kind, sizeof f.kind);
  mix(h, &n, sizeof n);
  mix(h, f.real.data(), f.real.size() * sizeof(double));
  mix(h, f.integer.data(), f.integer.size() * sizeof(std::int64_t));
  mix(h, f.byte.data(), f.byte.size());
}

std::string digits(std::uint64_t h) {
  char buf[17];
  std::snprintf(buf, sizeof buf, "%016llx", static_cast<unsigned long long>(h));
  return buf;
}
}  // namespace

StateStream::StateStream(Take take) : take_(std::move(take)), hash_(hash_begin) { state_.taker_.stream = this; }

void StateStream::take_all(const std::vector<State::Field>& fields) {
  for (const State::Field& f : fields) {
    mix(hash_, f);
    ++count_;
    if (take_) take_(f);
  }
}
void StateStream::finish() {
  take_all(state_.fields());
  state_.rewind(State::Mode::save);
}

std::size_t State::Field::size() const {
  return kind == Kind::real ? real.size() : kind == Kind::integer ? integer.size() : byte.size();
}

State::Group::Group(State& s, std::string_view name) : s_(s), old_(s.prefix_.size()) {
  s_.prefix_ += name;
  s_.prefix_ += '/';
}
State::Group::~Group() { s_.prefix_.resize(old_); }

void State::rewind(Mode mode) {
  mode_ = mode;
  cursor_ = 0;
  if (mode == Mode::save) fields_.clear();
}

void State::finish() const {
  if (loading() && cursor_ != fields_.size())
    throw StateError("state holds a field '" + fields_[cursor_].name + "' that nobody reads");
}

State::Field& State::next(std::string_view name, Kind kind) {
  std::string full = prefix_ + std::string(name);
  if (!loading()) {
    if (taker_.stream) {
      taker_.stream->take_all(fields_);
      fields_.clear();
    }
    fields_.push_back({std::move(full), kind, {}, {}, {}});
    return fields_.back();
  }
  if (cursor_ == fields_.size()) throw StateError("state ends before field '" + full + "'");
  Field& f = fields_[cursor_];
  if (f.name != full || f.kind != kind)
    throw StateError("state has field '" + f.name + "' where '" + full + "' is expected");
  ++cursor_;
  return f;
}

void State::reals(std::string_view name, double* x, std::size_t n) {
  Field& f = next(name, Kind::real);
  if (!loading()) {
    f.real.assign(x, x + n);
    return;
  }
  if (f.real.size() != n) throw StateError("state field '" + f.name + "' has another size");
  std::copy(f.real.begin(), f.real.end(), x);
}

void State::integers(std::string_view name, std::int64_t* x, std::size_t n) {
  Field& f = next(name, Kind::integer);
  if (!loading()) {
    f.integer.assign(x, x + n);
    return;
  }
  if (f.integer.size() != n) throw StateError("state field '" + f.name + "' has another size");
  std::copy(f.integer.begin(), f.integer.end(), x);
}

void State::field(std::string_view name, bool& x) {
  std::int64_t i = x;
  integers(name, &i, 1);
  x = i != 0;
}

void State::field(std::string_view name, std::string& x) {
  Field& f = next(name, Kind::byte);
  if (loading())
    x.assign(f.byte.begin(), f.byte.end());
  else
    f.byte.assign(x.begin(), x.end());
}

void State::field(std::string_view name, Pose& x) {
  double v[7] = {x.p.x(), x.p.y(), x.p.z(), x.q.x(), x.q.y(), x.q.z(), x.q.w()};
  reals(name, v, 7);
  x.p = {v[0], v[1], v[2]};
  x.q.coeffs() << v[3], v[4], v[5], v[6];
}

void State::field(std::string_view name, Twist& x) {
  double v[6] = {x.v.x(), x.v.y(), x.v.z(), x.w.x(), x.w.y(), x.w.z()};
  reals(name, v, 6);
  x.v = {v[0], v[1], v[2]};
  x.w = {v[3], v[4], v[5]};
}

void State::field(std::string_view name, std::vector<double>& x) {
  Field& f = next(name, Kind::real);
  loading() ? x = f.real : f.real = x;
}
void State::field(std::string_view name, std::vector<std::int64_t>& x) {
  Field& f = next(name, Kind::integer);
  loading() ? x = f.integer : f.integer = x;
}
void State::field(std::string_view name, std::vector<std::uint8_t>& x) {
  Field& f = next(name, Kind::byte);
  loading() ? x = f.byte : f.byte = x;
}

std::uint64_t State::hash() const {
  std::uint64_t h = hash_begin;
  for (const Field& f : fields_) mix(h, f);
  return h;
}

std::string State::hash_text() const { return digits(hash()); }
std::string StateStream::hash_text() const { return digits(hash_); }

namespace {
template <class T, class ToText>
std::optional<State::Difference> compare_values(const std::string& name, const std::vector<T>& a,
                                                const std::vector<T>& b, ToText text) {
  if (a.size() != b.size())
    return State::Difference{name, 0, "size " + std::to_string(a.size()), "size " + std::to_string(b.size())};
  for (std::size_t i = 0; i < a.size(); ++i)
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits are what must agree, NaN and -0.0 included
    if (std::memcmp(&a[i], &b[i], sizeof(T)) != 0) return State::Difference{name, i, text(a[i]), text(b[i])};
  return std::nullopt;
}
std::string real_text(double x) {
  char buf[32];
  std::snprintf(buf, sizeof buf, "%.17g", x);
  return buf;
}
}  // namespace

std::optional<State::Difference> State::first_difference(const State& a, const State& b) {
  const std::size_t n = std::min(a.fields_.size(), b.fields_.size());
  for (std::size_t i = 0; i < n; ++i) {
    const Field &x = a.fields_[i], &y = b.fields_[i];
    if (x.name != y.name || x.kind != y.kind) return Difference{x.name, 0, "field " + x.name, "field " + y.name};
    auto as_text = [](auto v) { return std::to_string(v); };
    auto d = x.kind == Kind::real      ? compare_values(x.name, x.real, y.real, real_text)
             : x.kind == Kind::integer ? compare_values(x.name, x.integer, y.integer, as_text)
                                       : compare_values(x.name, x.byte, y.byte, as_text);
    if (d) return d;
  }
  if (a.fields_.size() != b.fields_.size()) {
    const bool left = a.fields_.size() > n;
    return Difference{(left ? a : b).fields_[n].name, 0, left ? "present" : "absent", left ? "absent" : "present"};
  }
  return std::nullopt;
}

}  // namespace grouser
