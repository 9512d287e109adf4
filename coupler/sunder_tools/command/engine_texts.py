"""What `sunder engine new` writes."""
from __future__ import annotations

PYTHON = '''\
#!/usr/bin/python3
"""@name@: a rigid-body engine for Sunder. It has no contacts yet: each body goes on as the shell process predicts."""
import sys

sys.path.append(@modules@)  # where sunder_engine is
from sunder_engine import BAD_INPUT, Engine, Refused, main  # noqa: E402


class @type@(Engine):
    name, version = "@name@", "0.1"
    # Words of rigid/README.md. Declare one once its cases of the suite pass: "contact", "friction", ...
    # "contact" is held to all shapes declared: to begin with spheres, take the others out.
    capabilities = ["spheres", "boxes", "half_spaces", "convex_hulls", "compound", "deterministic", "double_precision"]

    def __init__(self):
        self.bodies = {}  # RigidBody by id: shape, mass, principal_inertia, is_static, contact_group
        self.moving = {}  # BodyState by id, of each body that is not static: position, orientation w x y z, velocity,
        #                     angular_momentum (world axes, about the centre of mass)

    def add(self, body):
        if body.mass > 1e9:  # refuse what your engine cannot hold
            raise Refused("bad_body", f"body {body.id}: {body.mass} kg is too heavy", BAD_INPUT)
        self.bodies[body.id] = body
        if not body.is_static:
            self.moving[body.id] = self.state_of(body)

    def advance(self, window_s, predicted, solved):
        for motion in predicted:
            # An engine with contacts solves them here. Start each body with the average velocity and angular velocity that
            # lead from self.moving[motion.id] to motion in window_s. Then add what the contacts changed: of velocity to
            # motion.velocity, window_s times it to motion.position, inertia times the change of angular velocity to
            # motion.angular_momentum, and what it turns in window_s to motion.orientation (rigid/README.md, "A window").
            self.move(self.moving[motion.id], motion)

    def states(self):
        return [self.moving[number] for number in sorted(self.moving)]


if __name__ == "__main__":
    sys.exit(main(@type@))
'''
CPP = '''\
// @name@: a rigid-body engine for Sunder. It has no contacts yet: each body goes on as the shell process predicts.
#include <map>

#include "coupler/link/engine_main.h"

using namespace sunder;

namespace {

class @type@ final : public link::Engine {
 public:
  link::EngineInfo info() const override {
    // Words of rigid/README.md. Declare one once its cases of the suite pass: "contact", "friction", ...
    // "contact" is held to all shapes declared: to begin with spheres, take the others out.
    return {"@name@",
            "0.1",
            {"spheres", "boxes", "half_spaces", "convex_hulls", "compound", "deterministic", "double_precision"}};
  }
  void add(const RigidBody& body) override {
    if (body.mass > 1e9)  // refuse what your engine cannot hold
      throw Error(Exit::kBadInput, "bad_body", fmt::format("body {}: {} kg is too heavy", body.id, body.mass));
    bodies_[body.id] = body;
  }
  void set_contact_laws(const std::vector<ContactLaw>&) override {}
  void advance(double /*window_s*/, const std::vector<link::Motion>& predicted,
               const std::vector<BodyId>& /*solved*/) override {
    // An engine with contacts solves them here. Start each body with the average velocity and angular velocity that lead
    // from its motion to the predicted one in window_s. Then add what the contacts changed: of velocity to the predicted
    // velocity, window_s times it to the position, inertia times the change of angular velocity to the angular momentum,
    // and what it turns in window_s to the orientation (rigid/README.md, "A window").
    for (const link::Motion& m : predicted) bodies_.at(m.id).motion = m.motion;
  }
  std::vector<link::State> states() const override {
    std::vector<link::State> out;
    for (const auto& [id, body] : bodies_)
      if (!body.is_static) out.push_back({id, body.mass, body.motion});
    return out;
  }

 private:
  std::map<BodyId, RigidBody> bodies_;
};

}  // namespace

int main(int argc, char** argv) {
  return link::engine_main("@name@", argc, argv, [] { return std::make_unique<@type@>(); });
}
'''
CMAKE = '''\
# Built within the project's own build, which SUNDER_ENGINES tells of this folder.
add_executable(@name@ @name@.cpp)
target_link_libraries(@name@ PRIVATE sunder_link)
set_target_properties(@name@ PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
'''
NODE = '''\
#!/usr/bin/env node
// @name@: a rigid-body engine for Sunder. It has no contacts yet: each body goes on as the shell process predicts.
import { engineMain, Exit, Failure } from @main@;

class @type@ {
  // Words of rigid/README.md. Declare one once its cases of the suite pass: 'contact', 'friction', ...
  // 'contact' is held to all shapes declared: to begin with spheres, take the others out.
  info = {
    name: '@name@',
    version: '0.1',
    capabilities: ['spheres', 'boxes', 'half_spaces', 'convex_hulls', 'compound', 'deterministic', 'double_precision'],
  };
  moving = new Map(); // by id, each body that is not static: its mass, position, orientation [w, x, y, z], velocity and
  //                     angular_momentum (world axes, about the centre of mass)

  // A body has id, mass, principal_inertia, is_static, contact_group, motion and shape: { sphere: radius }, { box: half
  // size }, { half_space: true } or { parts: corners of each convex part }.
  add({ id, mass, is_static: isStatic, motion }) {
    if (mass > 1e9) // refuse what your engine cannot hold
      throw new Failure(Exit.badInput, 'bad_body', `body ${id}: ${mass} kg is too heavy`);
    if (!isStatic) this.moving.set(id, { id, mass, ...motion });
  }

  setContactLaws(laws) {} // { first_group, second_group, friction, restitution } each

  advance(window_s, predicted, solved) {
    for (const motion of predicted) {
      // An engine with contacts solves them here. Start each body with the average velocity and angular velocity that
      // lead from this.moving.get(motion.id) to motion in window_s. Then add what the contacts changed: of velocity to
      // motion.velocity, window_s times it to motion.position, inertia times the change of angular velocity to
      // motion.angular_momentum, and what it turns in window_s to motion.orientation (rigid/README.md, "A window").
      Object.assign(this.moving.get(motion.id), motion);
    }
  }

  states() {
    return [...this.moving.values()].sort((a, b) => a.id - b.id);
  }
}

await engineMain('@name@', () => new @type@());
'''
