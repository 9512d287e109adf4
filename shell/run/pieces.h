#pragma once
// Detached pieces leave the shells as rigid bodies. When cracking has ended, the held part leaves as a static body.
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "coupler/core/disjoint_sets.h"
#include "shell/io/frames.h"
#include "shell/run/books.h"
#include "shell/run/coupler.h"
#include "shell/run/piece_ids.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// A piece that was handed off: a row of shards.csv.
struct ShardRecord {
  BodyId id = 0;                               // of the piece, as it was in the shell
  BodyId body = 0;                             // of the body
  double birth = 0.0, area = 0.0, mass = 0.0;  // [s], [m^2], [kg]
  double birth_speed = 0.0;                    // [m/s]
  int parts = 0;                               // number of convex parts
};

/// Counts and sums over all pieces so far. Plain numbers, so a checkpoint stores them as bytes.
struct PieceCounts {
  BodyId first_shard = 1, next_id = 1;
  int fragments = 0, handed_off = 0, rubble_points = 0;
  double handed_area = 0.0, detached_area = 0.0;  // [m^2]
  double geometry_error = 0.0;  // largest relative difference between a shard's mass and that of its area [-]
  double frozen_at = -1.0;      // [s]; negative while the shell is solved
};

/// Throws Error (parts) where a new body has more convex parts, or one of them more corners, than a message may carry.
void check_parts(const RigidBody& body, std::int64_t window);

/// Returns the error with its window and its body before the text, as far as they are known. An engine knows a body by
/// its id in the exchange; the name comes from `bodies`, and is left out where the text has it.
Error with_place(const Error& error, const std::vector<Proxy>& bodies);

/// Finds detached pieces, hands them off, and freezes the shells.
class Pieces {
 public:
  /// All references must outlive it.
  Pieces(const RunSetup& setup, Simulation& simulation, Coupler& coupler, Books& books, const Clock& clock,
         FrameWriter& frames);

  /// Gives ids to the pieces of this moment. hand_off_pieces() and freeze() do so too. Call it at the start, and where
  /// cuts have been made at a window's start.
  void look();
  /// Hands off the pieces that are due, or every loose piece where `all`. Returns their bodies. `dt` is the substep
  /// [s]. Throws Error (ledger) where mass or momentum is lost.
  std::vector<RigidBody> hand_off_pieces(bool all, double dt);
  /// Returns why the shells may be frozen now, or an empty text. `last_push` is the time [s] of a body's last push.
  std::string cracking_has_ended(double last_push);
  /// Hands off loose pieces, turns the held part into static bodies, and empties the shells. Returns all these bodies.
  /// `why` is kept for run.json; `dt` is the substep [s].
  std::vector<RigidBody> freeze(const std::string& why, double dt);

  const PieceIds& ids() const { return ids_; }
  const PieceCounts& counts() const { return counts_; }
  const std::vector<ShardRecord>& shards() const { return shards_; }
  const std::string& frozen_why() const { return frozen_why_; }
  const std::string& frozen_hash() const { return frozen_hash_; }
  double frozen_wall() const { return frozen_wall_; }  // wall clock of freezing [s]

  template <class A>
  friend void archive(A& a, Pieces& p) {
    archive_all(a, p.counts_, p.ids_, p.shards_, p.crack_lengths_, p.frozen_why_, p.frozen_hash_);
  }

 private:
  /// Pieces (shell, index) that are joined to each other.
  struct Group {
    std::vector<std::pair<std::size_t, std::size_t>> members;
    bool empty = true;   // none has a control point
    bool sliver = true;  // smaller than what joins a neighbour in a triangulation
    bool bends = false;  // large enough to bend
    bool torn = false;   // of a shell that is in pieces, or detached from a shell that it was joined to
  };
  /// Boxes in the parameters of each shell.
  using PartBoxes = std::vector<std::vector<Eigen::AlignedBox2d>>;
  /// Returns the pieces of all shells. Pieces in the boxes `leaving` are fit to be handed off; others are only counted.
  std::vector<PartPieces> pieces_now(bool all, const PartBoxes& leaving);
  /// Joins the pieces that seams hold together. The pieces of shell k are numbered from first[k] on.
  DisjointSets sewn(const std::vector<PartPieces>& now, std::vector<int>& first) const;
  void give_ids(const std::vector<PartPieces>& now);
  PartBoxes everywhere() const;
  PartBoxes boxes_of(const std::vector<PartPieces>& now, const std::map<int, Group>& groups,
                     const std::vector<int>& roots) const;
  std::map<int, Group> groups_of(const std::vector<PartPieces>& now) const;
  /// Tests whether a group is so soft, by the policy of its shells, that it stays in the shell solver.
  bool stays_soft(const std::vector<PartPieces>& now, const Group& group) const;
  bool is_to_leave(const std::vector<PartPieces>& now, const Group& group, bool all);
  Totals shell_totals();
  /// Hands off one group and returns its body. `totals_now` are the totals of the shells; they are updated.
  RigidBody hand_off_group(std::vector<PartPieces>& now, const Group& group, Totals& totals_now, double dt);
  void check_handoff(const Totals& before, const Totals& after, const RigidBody& body);
  /// Tests whether a moving body of the scene flies towards the pieces of a group, with energy enough for a crack
  /// across them.
  bool strike_ahead(const std::vector<PartPieces>& now, const Group& group) const;
  bool impact_ahead() const;  // a body of the scene flies towards a shell
  bool impact_ahead(const ShellPart& part) const;
  void note_body_beside(const std::vector<PartPieces>& now);

  const RunSetup& setup_;
  Simulation& simulation_;
  State& state_;
  Coupler& coupler_;
  Books& books_;
  const Clock& clock_;
  FrameWriter& frames_;
  PieceIds ids_;
  PieceCounts counts_;
  std::vector<ShardRecord> shards_;
  std::deque<std::pair<double, double>> crack_lengths_;  // time [s], total length [m], over the quiet time
  std::string frozen_why_, frozen_hash_;
  double frozen_wall_ = 0.0;
  bool soft_left_ = false;  // a piece that has come off stays a shell; found anew at each look for pieces
};

}  // namespace sunder::shell
