#include "rigid/engine/bullet_joints.h"

#include <algorithm>
#include <utility>

#include "coupler/core/error.h"
#include "rigid/engine/bullet_shapes.h"
#include "rigid/engine/bullet_tag.h"

namespace sunder::rigid {
namespace {

/// Added share of the diagonal, for redundant joints, such as two hinges of one door: their matrix is singular.
constexpr double kSoftness = 1e-10;  // [-]

}  // namespace

BulletJoints::Impulses BulletJoints::impulses() const {
  Impulses result;
  for (const auto& [id, joint] : joints_) result[id] = joint->impulses();
  return result;
}

std::map<std::uint32_t, std::unique_ptr<BulletJoint>> BulletJoints::take_out() {
  acting_.clear();
  return std::exchange(joints_, {});
}

bool BulletJoints::choose(const std::set<BodyId>& solved) {
  acting_.clear();
  held_.clear();
  for (const auto& [id, joint] : joints_) {
    const BodyId first = BodyTag::id(joint->getRigidBodyA()), second = BodyTag::id(joint->getRigidBodyB());
    const bool elsewhere = solved.count(first) > 0 || solved.count(second) > 0 || released_.count(id) > 0;
    joint->setEnabled(!elsewhere);
    if (elsewhere) {
      joint->set_impulses({});  // they do not fit the next window in which it acts
      continue;
    }
    acting_.push_back(joint.get());
    held_.insert({first, second});
  }
  return any();
}

void BulletJoints::begin(BulletJoint::Stage stage, double window_s) {
  stage_ = stage;
  for (BulletJoint* joint : acting_) {
    joint->find_rows();
    if (stage == BulletJoint::kSolve)
      joint->aim(window_s);
    else
      joint->aim_still();
  }
  factorize();
}

void BulletJoints::factorize() {
  using Row = BulletJoint::Row;
  struct End {
    std::size_t joint;
    bool second;
  };
  std::map<BodyId, std::vector<End>> ends;  // of joints, by moving body
  first_rows_ = {0};
  for (std::size_t j = 0; j < acting_.size(); ++j) {
    const BulletJoint& joint = *acting_[j];
    if (!joint.getRigidBodyA().isStaticObject()) ends[BodyTag::id(joint.getRigidBodyA())].push_back({j, false});
    if (!joint.getRigidBodyB().isStaticObject()) ends[BodyTag::id(joint.getRigidBodyB())].push_back({j, true});
    first_rows_.push_back(first_rows_.back() + static_cast<int>(joint.rows().size()));
  }
  std::vector<Eigen::Triplet<double>> entries;
  const auto angular = [](const Row& row, bool second) { return second ? row.second_angular : row.first_angular; };
  for (const auto& [id, of_body] : ends)
    for (const End& p : of_body)
      for (const End& q : of_body) {
        const BulletJoint &first = *acting_[p.joint], &second = *acting_[q.joint];
        const btRigidBody& body = p.second ? first.getRigidBodyB() : first.getRigidBodyA();
        const double sign = p.second == q.second ? 1.0 : -1.0;
        for (std::size_t i = 0; i < first.rows().size(); ++i)
          for (std::size_t k = 0; k < second.rows().size(); ++k) {
            const Row &a = first.rows()[i], &b = second.rows()[k];
            const int row = first_rows_[p.joint] + static_cast<int>(i),
                      column = first_rows_[q.joint] + static_cast<int>(k);
            const double entry = sign * body.getInvMass() * a.linear.dot(b.linear) +
                                 angular(a, p.second).dot(body.getInvInertiaTensorWorld() * angular(b, q.second));
            entries.emplace_back(row, column, row == column ? (1.0 + kSoftness) * entry : entry);
          }
      }
  Eigen::SparseMatrix<double> matrix(first_rows_.back(), first_rows_.back());
  matrix.setFromTriplets(entries.begin(), entries.end());
  factors_.compute(matrix);
  ensure(factors_.info() == Eigen::Success, "joints with {} rows cannot be solved", first_rows_.back());
}

void BulletJoints::push() {
  for (BulletJoint* joint : acting_) joint->push(stage_);
}

void BulletJoints::take_in(double window_s) {
  for (BulletJoint* joint : acting_) joint->take_in(stage_, window_s);
}

double BulletJoints::correct() {
  Eigen::VectorXd missing(first_rows_.back());
  for (std::size_t j = 0; j < acting_.size(); ++j)
    for (int k = first_rows_[j]; k < first_rows_[j + 1]; ++k) missing[k] = acting_[j]->missing(k - first_rows_[j]);
  const Eigen::VectorXd impulses = factors_.solve(missing);
  double most = 0.0;
  for (std::size_t j = 0; j < acting_.size(); ++j)
    most = std::max(most, acting_[j]->give(stage_, impulses.data() + first_rows_[j]));
  return most;
}

double BulletJoints::mend(double window_s, const std::function<btTransform(BodyId)>& end_of) {
  const auto end = [&](const btRigidBody& body) {
    return body.isStaticObject() ? body.getWorldTransform() : end_of(BodyTag::id(body));
  };
  double worst = 0.0;
  for (BulletJoint* joint : acting_)
    worst = std::max(worst, joint->mend(end(joint->getRigidBodyA()), end(joint->getRigidBodyB()), window_s));
  return worst;
}

}  // namespace sunder::rigid
