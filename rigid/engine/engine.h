#pragma once
// The engines of this house, by name. Nothing outside this folder names one.
#include <memory>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::rigid {

using link::ContactRow;
using link::Engine;
using link::EngineInfo;

/// Where the solver's copy of a body has come by itself at the end of a window: free flight, gravity
/// and contact with the shell included, contacts and joints between rigid bodies not.
using PredictedState = link::Motion;
using EngineState = link::State;

/// Names that make_engine takes.
std::vector<std::string> engine_names();
/// Throws Error (unknown_engine) with the names that there are.
std::unique_ptr<Engine> make_engine(const std::string& name);

}  // namespace sunder::rigid
