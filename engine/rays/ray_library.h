#pragma once

#include <string>

namespace aula {

/// Name and version of the library that traces rays in a RayScene, as "Embree 4.3.3".
std::string ray_library();

}  // namespace aula
