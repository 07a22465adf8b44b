#include <catch2/catch.hpp>
#include <string_view>

#undef __GLIBC__
#include "engine/process/multiversion.h"

#define AULA_TEXT_OF(...) #__VA_ARGS__
#define AULA_TEXT(macro) AULA_TEXT_OF(macro)

TEST_CASE("Functions have one version where the C library is not glibc") {
    CHECK(std::string_view(AULA_TEXT(AULA_MULTIVERSION)).empty());
}
