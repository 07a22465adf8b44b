#pragma once

namespace aula::godot {

// Of Node.
constexpr int kEnterTree = 10;
constexpr int kExitTree = 11;
constexpr int kInternalProcess = 25;
/// The node and those below it are in the tree.
constexpr int kPostEnterTree = 27;

}  // namespace aula::godot
