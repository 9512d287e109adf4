#include "rigid/engine/dart_solver.h"

#include <dart/config.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/core/error.h"

namespace sunder::rigid {
namespace {

using dart::dynamics::BodyNode;
using dart::dynamics::SkeletonPtr;

/// Largest number of rows of a group for the exact solver, whose time grows with their cube.
constexpr std::size_t kExactRows = 1200;
constexpr int kSweeps = 100;
/// Softness of every row relative to its inverse mass. The exact solver factorises a matrix that would be singular,
/// because several corners of one plate are redundant.
constexpr double kSoftness = 1e-9;  // [-]
/// Above this ratio of masses a light body is within the round-off of a heavy one. The library ends its process then.
constexpr double kLargestRatio = 1.0 / std::numeric_limits<double>::epsilon();  // [-]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One row: an impulse along `linear` and `angular` on the first body, and the opposite one on the second.
struct Row {
  Vec3 linear = Vec3::Zero();
  Vec3 first_arm = Vec3::Zero(), second_arm = Vec3::Zero();  // from the centres to where it acts [m]
  bool turns_only = false;                                   // the row is a moment along `linear`
  double wanted = 0.0;                                       // change of the relative velocity [m/s]

  Eigen::Matrix<double, 6, 1> on(const Vec3& arm) const {  // DART's order: moment, force
    Eigen::Matrix<double, 6, 1> out;
    if (turns_only)
      out << linear, Vec3::Zero();
    else
      out << arm.cross(linear), linear;
    return out;
  }
};

/// Rows between two bodies for DART's solver. The skeletons stand at the origin with the world's axes, so body
/// coordinates are differences to the centre of mass in world axes, free of round-off.
class Rows final : public dart::constraint::ConstraintBase {
 public:
  /// `second`: null for the world. Bounds are those of a joint; a `contact` has its normal first, then friction.
  Rows(BodyNode* first, BodyNode* second, dart::dynamics::SkeletonPtr group, std::vector<Row> rows, bool contact,
       double friction)
      : group_(std::move(group)), rows_(std::move(rows)), contact_(contact), friction_(friction) {
    mDim = rows_.size();
    for (BodyNode* body : {first, second})
      if (body) ends_.push_back({body, body->getSkeleton().get(), {}});
    for (const Row& row : rows_) {
      if (first) ends_[0].on.push_back(row.on(row.first_arm));
      if (second) ends_.back().on.push_back(-row.on(row.second_arm));
    }
  }
  /// Impulse along the first row, after the solution.
  double impulse() const { return impulse_; }
  /// True where a solution has an impulse.
  bool is_violated() const {
    if (contact_) return rows_[0].wanted > 0.0;
    return std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.wanted != 0.0; });
  }
  bool acted() const { return acted_; }

  void update() override {}
  bool isActive() const override { return true; }
  SkeletonPtr getRootSkeleton() const override { return group_; }  // one for all rows that are solved together
  void getInformation(dart::constraint::ConstraintInfo* info) override {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const bool tangent = contact_ && i > 0;
      info->x[i] = info->w[i] = 0.0;
      info->b[i] = rows_[i].wanted;
      info->lo[i] = !contact_ ? -kInfinity : tangent ? -friction_ : 0.0;
      info->hi[i] = tangent ? friction_ : kInfinity;
      info->findex[i] = tangent ? 0 : -1;  // the normal of this contact
    }
  }
  void applyUnitImpulse(std::size_t index) override {
    for (const End& end : ends_) {
      end.skeleton->clearConstraintImpulses();
      end.skeleton->updateBiasImpulse(end.body, end.on[index]);
      end.skeleton->updateVelocityChange();
    }
    applied_ = index;
  }
  void getVelocityChange(double* change, bool with_softness) override {
    std::fill_n(change, rows_.size(), 0.0);
    for (const End& end : ends_) {
      if (!end.skeleton->isImpulseApplied()) continue;
      const Eigen::Matrix<double, 6, 1>& moved = end.body->getBodyVelocityChange();
      for (std::size_t i = 0; i < rows_.size(); ++i) change[i] += end.on[i].dot(moved);
    }
    if (with_softness) change[applied_] *= 1.0 + kSoftness;
  }
  void excite() override { touch(true); }
  void unexcite() override { touch(false); }
  void applyImpulse(double* impulses) override {
    for (const End& end : ends_)
      for (std::size_t i = 0; i < rows_.size(); ++i) end.body->addConstraintImpulse(impulses[i] * end.on[i]);
    impulse_ = impulses[0];
    acted_ = std::any_of(impulses, impulses + rows_.size(), [](double one) { return one != 0.0; });
  }

 private:
  struct End {
    BodyNode* body;
    dart::dynamics::Skeleton* skeleton;           // the body's; to share it takes long
    std::vector<Eigen::Matrix<double, 6, 1>> on;  // by row: what a unit impulse does to the body
  };
  void touch(bool applied) {
    for (const End& end : ends_) end.skeleton->setImpulseApplied(applied);
  }

  SkeletonPtr group_;
  std::vector<Row> rows_;
  std::vector<End> ends_;
  bool contact_;
  double friction_;
  std::size_t applied_ = 0;
  double impulse_ = 0.0;
  bool acted_ = false;
};

/// Where an end of a joint is: its anchor and its axes, in world coordinates. `body`: null for the world.
struct Anchor {
  Vec3 arm, place;
  Quat axes;
};
Anchor anchor(const SolverBody* body, const Joint::Frame& frame) {
  if (!body) return {frame.position, frame.position, frame.orientation};
  const Vec3 arm = body->orientation * frame.position;
  return {arm, body->position + arm, body->orientation * frame.orientation};
}

/// Rows of a joint whose errors shrink by `rate` of theirs a second [1/s].
std::vector<Row> rows_of(const SolverJoint& joint, const std::vector<SolverBody>& bodies, double rate) {
  const SolverBody &a = bodies[joint.first], *b = joint.second < 0 ? nullptr : &bodies[joint.second];
  const Anchor first = anchor(&a, joint.first_frame), second = anchor(b, joint.second_frame);
  const Vec3 apart = first.place - second.place;
  const Vec3 spin = a.spin - (b ? b->spin : Vec3(Vec3::Zero()));
  const Eigen::Matrix3d axes = second.axes.toRotationMatrix();
  const bool slides = joint.kind == Joint::Kind::kSlider;
  // a slider acts where its first end is: its second one moves along
  const Vec3 second_arm = slides ? Vec3(second.arm + apart) : second.arm;
  const Vec3 second_velocity = b ? Vec3(b->velocity + b->spin.cross(second_arm)) : Vec3(Vec3::Zero());
  const Vec3 slip = a.velocity + a.spin.cross(first.arm) - second_velocity;
  std::vector<Row> rows;
  for (int i = 0; i < (slides ? 2 : 3); ++i) {
    const Vec3 along = axes.col(i);
    rows.push_back({along, first.arm, second_arm, false, -along.dot(slip + rate * apart)});
  }
  if (joint.kind == Joint::Kind::kBall) return rows;
  const bool hinge = joint.kind == Joint::Kind::kHinge;
  const Vec3 turned = hinge ? Vec3(axes.col(2).cross(first.axes * Vec3::UnitZ()))
                            : rotation_vector(first.axes * second.axes.conjugate());
  const double lever = std::sqrt(a.inertia.maxCoeff() / a.mass);  // so that numbers are as those of the other rows [m]
  for (int i = 0; i < (hinge ? 2 : 3); ++i) {
    const Vec3 about = lever * axes.col(i);
    rows.push_back({about, Vec3::Zero(), Vec3::Zero(), true, -about.dot(spin + rate * turned)});
  }
  return rows;
}

std::vector<Row> rows_of(const SolverContact& contact, const std::vector<SolverBody>& bodies, double offset) {
  const SolverBody &a = bodies[contact.first], *b = contact.second < 0 ? nullptr : &bodies[contact.second];
  const Vec3 first_arm = contact.point - a.position, second_arm = b ? Vec3(contact.point - b->position) : Vec3::Zero();
  const Vec3 slip = velocity_at(a, contact.point) - (b ? velocity_at(*b, contact.point) : Vec3(Vec3::Zero()));
  std::vector<Row> rows{
      {contact.normal, first_arm, second_arm, false, contact.target - offset - contact.normal.dot(slip)}};
  if (contact.friction > 0.0) {
    const Vec3 direction = slip_direction(contact, bodies);
    for (const Vec3& along : {direction, Vec3(contact.normal.cross(direction))})
      rows.push_back({along, first_arm, second_arm, false, -along.dot(slip)});
  }
  return rows;
}

}  // namespace

struct DartSolver::Impl {
  dart::constraint::BoxedLcpConstraintSolver exact, sweeps;
  std::vector<SkeletonPtr> skeletons;  // of the bodies of a group; kept, because they take long to make

  Impl() : exact(std::make_shared<dart::constraint::DantzigBoxedLcpSolver>(), swept()), sweeps(swept(), nullptr) {}

  static dart::constraint::BoxedLcpSolverPtr swept() {
    const auto solver = std::make_shared<dart::constraint::PgsBoxedLcpSolver>();
    solver->setOption({kSweeps, 0.0, 0.0, 0.0, false});
    return solver;
  }
  BodyNode* place(std::size_t slot, const SolverBody& body, double unit);
  void solve(double rate, std::vector<SolverBody>& bodies, const Island& island);
};

/// The body's skeleton, at rest. `unit`: its masses are in units of this [kg].
BodyNode* DartSolver::Impl::place(std::size_t slot, const SolverBody& body, double unit) {
  if (slot == skeletons.size()) {
    skeletons.push_back(dart::dynamics::Skeleton::create());
    skeletons.back()->createJointAndBodyNodePair<dart::dynamics::FreeJoint>();
  }
  const SkeletonPtr& skeleton = skeletons[slot];
  BodyNode* node = skeleton->getBodyNode(0);
  const Eigen::Matrix3d turn = body.orientation.toRotationMatrix();
  const Eigen::Matrix3d inertia = turn * (body.inertia / unit).asDiagonal() * turn.transpose();
  node->setInertia(dart::dynamics::Inertia(body.mass / unit, Vec3::Zero(), inertia));
  skeleton->resetVelocities();
  skeleton->clearConstraintImpulses();
  skeleton->setImpulseApplied(false);
  return node;
}

void DartSolver::Impl::solve(double rate, std::vector<SolverBody>& bodies, const Island& island) {
  // The library checks that its matrix is symmetric to a fixed 1e-6, so its numbers should be about 1.
  double unit = bodies[island.bodies.front()].mass, heaviest = unit;
  for (const int i : island.bodies) {
    unit = std::min(unit, bodies[i].mass);
    heaviest = std::max(heaviest, bodies[i].mass);
  }
  if (!(heaviest / unit < kLargestRatio))
    throw Error(Exit::kPhysics, "engine",
                fmt::format("bodies of {} and {} kg meet in a group of {}; dart holds ratios below {:.1g}", unit,
                            heaviest, island.bodies.size(), kLargestRatio));
  std::vector<BodyNode*> nodes(bodies.size(), nullptr);
  for (std::size_t k = 0; k < island.bodies.size(); ++k)
    nodes[island.bodies[k]] = place(k, bodies[island.bodies[k]], unit);
  const auto of = [&](int i) { return i < 0 ? nullptr : nodes[i]; };
  const SkeletonPtr& group = skeletons.front();
  auto& solver = static_cast<std::size_t>(island.rows()) <= kExactRows ? exact : sweeps;
  std::vector<std::shared_ptr<Rows>> all;
  for (const SolverJoint* j : island.joints)
    all.push_back(std::make_shared<Rows>(of(j->first), of(j->second), group, rows_of(*j, bodies, rate), false, 0.0));
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const SolverContact& c = *island.contacts[i];
    all.push_back(std::make_shared<Rows>(of(c.first), of(c.second), group, rows_of(c, bodies, target_offset(i)), true,
                                         c.friction));
  }
  for (const auto& rows : all) solver.addConstraint(rows);
  solver.solve();
  solver.removeAllConstraints();
  // Where neither of its solvers finds numbers, DART goes on without impulses, and says so on the terminal only.
  bool found = std::any_of(all.begin(), all.end(), [](const auto& rows) { return rows->acted(); }) ||
               std::none_of(all.begin(), all.end(), [](const auto& rows) { return rows->is_violated(); });
  for (const int i : island.bodies) {
    const SkeletonPtr skeleton = nodes[i]->getSkeleton();
    if (!skeleton->isImpulseApplied()) continue;
    skeleton->computeImpulseForwardDynamics();
    const Eigen::Matrix<double, 6, 1>& change = nodes[i]->getBodyVelocityChange();
    found = found && change.allFinite();
    bodies[i].spin += change.head<3>();
    bodies[i].velocity += change.tail<3>();
  }
  if (!found)
    throw Error(Exit::kPhysics, "engine",
                fmt::format("dart finds no finite velocities for {} bodies with {} contacts and {} joints",
                            island.bodies.size(), island.contacts.size(), island.joints.size()));
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(island.joints.size());
  for (std::size_t i = 0; i < island.contacts.size(); ++i)
    island.contacts[i]->acted = first[static_cast<std::ptrdiff_t>(i)]->impulse() > 0.0;
}

DartSolver::DartSolver() : impl_(std::make_unique<Impl>()) {}
DartSolver::~DartSolver() = default;

std::string DartSolver::version() const { return DART_VERSION; }

void DartSolver::solve(double window_s, double joint_share, std::vector<SolverBody>& bodies,
                       const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts) {
  for (const Island& island : islands(bodies.size(), joints, contacts))
    impl_->solve(joint_share / window_s, bodies, island);
}

}  // namespace sunder::rigid
