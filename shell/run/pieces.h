#pragma once
// Pieces that have come off leave the shells as rigid bodies; in the end the part that a support holds does too.
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "shell/io/frames.h"
#include "shell/run/books.h"
#include "shell/run/coupler.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// A piece that was handed off, as shards.csv has it.
struct ShardRecord {
  BodyId id = 0;
  double birth = 0.0, area = 0.0, mass = 0.0;  // [s], [m^2], [kg]
  double birth_speed = 0.0;                    // [m/s]
  int parts = 0;                               // convex ones
};

/// Counts and sums over all pieces so far; plain numbers, so that a checkpoint keeps them as they lie.
struct PieceCounts {
  BodyId first_shard = 1, next_id = 1;
  int fragments = 0, handed_off = 0, rubble_points = 0;
  double handed_area = 0.0, detached_area = 0.0;  // [m^2]
  double geometry_error = 0.0;                    // largest relative error of a shard's mass by its shape [-]
  double frozen_at = -1.0;                        // [s]; negative: the shell is still solved
};

class Pieces {
 public:
  /// All of these outlive it.
  Pieces(const RunSetup& setup, Simulation& simulation, Coupler& coupler, Books& books, const Clock& clock,
         FrameWriter& frames);

  /// Pieces that are to leave do so, all that is loose where `all`; returns their bodies. `dt` is the substep [s].
  /// Throws Error (ledger) where mass or momentum is lost.
  std::vector<RigidBody> take_off(bool all, double dt);
  /// Why the shell may be frozen now; empty: it may not.
  std::string cracking_has_ended(double last_push);
  /// Takes off what is loose, makes the held part static bodies, and empties the shells. Returns the bodies.
  std::vector<RigidBody> freeze(const std::string& why, double dt);

  const PieceCounts& counts() const { return counts_; }
  const std::vector<ShardRecord>& shards() const { return shards_; }
  const std::string& frozen_why() const { return frozen_why_; }
  const std::string& frozen_hash() const { return frozen_hash_; }
  double frozen_wall() const { return frozen_wall_; }  // wall clock at that moment [s]

  template <class A>
  friend void archive(A& a, Pieces& p) {
    archive_all(a, p.counts_, p.shards_, p.crack_lengths_, p.frozen_why_, p.frozen_hash_);
  }

 private:
  /// Pieces, by shell and index, that hang together.
  struct Group {
    std::vector<std::pair<std::size_t, std::size_t>> members;
    bool empty = true;   // no control point
    bool bends = false;  // is large
    bool torn = false;   // of a shell that is in pieces, or off one that it was joined to
  };
  /// Of each shell, boxes in its parameters.
  using PartBoxes = std::vector<std::vector<Eigen::AlignedBox2d>>;
  /// Fit to leave in the boxes; of shells that have none, and of all where none are given, only counted.
  std::vector<PartPieces> pieces_now(bool all, const PartBoxes& leaving);
  PartBoxes everywhere() const;
  PartBoxes boxes_of(const std::vector<PartPieces>& now, const std::map<int, Group>& groups,
                     const std::vector<int>& roots) const;
  std::map<int, Group> groups_of(const std::vector<PartPieces>& now) const;
  bool is_to_leave(const std::vector<PartPieces>& now, const Group& group, bool all);
  Totals shell_totals();
  /// `totals_now`: those of the shells, which it keeps up to date.
  RigidBody leave(std::vector<PartPieces>& now, const Group& group, Totals& totals_now, double dt);
  void check_handoff(const Totals& before, const Totals& after, const RigidBody& body);
  bool impact_ahead() const;  // a body of the scene flies towards a shell
  bool impact_ahead(const ShellPart& part) const;

  const RunSetup& setup_;
  Simulation& simulation_;
  State& state_;
  Coupler& coupler_;
  Books& books_;
  const Clock& clock_;
  FrameWriter& frames_;
  PieceCounts counts_;
  std::vector<ShardRecord> shards_;
  std::deque<std::pair<double, double>> crack_lengths_;  // time [s], total length [m], over the quiet time
  std::string frozen_why_, frozen_hash_;
  double frozen_wall_ = 0.0;
};

}  // namespace sunder::shell
