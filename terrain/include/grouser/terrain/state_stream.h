#pragma once
// States that are too large to be held beside what they are the state of.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "grouser/terrain/state.h"

namespace grouser {

/// A State in mode save whose fields are handed over one by one and not kept:
///
///   StateStream s(write_to_disk);
///   model.traverse(s.state());
///   s.finish();
///
/// Memory: two copies of the largest field. Streams may be open beside each other, in one thread or several.
class StateStream {
 public:
  using Take = std::function<void(const State::Field&)>;
  /// `take` gets every field when the next one begins, the last one in finish(); empty: only the hash is wanted.
  explicit StateStream(Take take = {});
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  State& state() { return state_; }
  void finish();
  std::uint64_t hash() const { return hash_; }  ///< State::hash() of all fields handed over so far
  std::string hash_text() const;                ///< 16 hexadecimal digits
  std::uint64_t fields() const { return count_; }

 private:
  friend class State;
  void take_all(const std::vector<State::Field>& fields);
  State state_;
  Take take_;
  std::uint64_t hash_, count_ = 0;
};

}  // namespace grouser
