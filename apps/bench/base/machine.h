#pragma once

#include <string>

namespace aula::bench {

/// Properties of a machine that measured times depend on.
struct Machine {
    std::string processor;  ///< model
    unsigned processors = 0;
    std::string instruction_set;  ///< the widest vectors that the processor and Aula have
    std::string compiler;         ///< and build type
    std::string revision;         ///< commit of the sources when this program was built
};

/// The machine that runs this program.
Machine machine();

/// The same in one line.
std::string machine_line();

}  // namespace aula::bench
