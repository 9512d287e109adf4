// sunder-rigid-dart: the rigid process with DART. It serves one session.
#include "coupler/link/engine_main.h"
#include "rigid/engine/dart_solver.h"
#include "rigid/engine/window_engine.h"

int main(int argc, char** argv) {
  using namespace sunder::rigid;
  return sunder::link::engine_main("sunder-rigid-dart", argc, argv,
                                   [] { return std::make_unique<WindowEngine>(std::make_unique<DartSolver>()); });
}
