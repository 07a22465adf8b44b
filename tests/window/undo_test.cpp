#include "apps/window/model/undo.h"

#include <catch2/catch.hpp>
#include <string>

using aula::Undo;

TEST_CASE("Redo restores undone values until a new value is set") {
    Undo<std::string> undo("plaster");
    CHECK_FALSE(undo.can_undo());
    undo.undo();
    CHECK(undo.now() == "plaster");
    undo.change("curtain");
    undo.change("glass");
    undo.undo();
    CHECK(undo.now() == "curtain");
    CHECK(undo.can_redo());
    undo.redo();
    CHECK(undo.now() == "glass");
    undo.undo();
    undo.undo();
    CHECK(undo.now() == "plaster");
    undo.change("wood");
    CHECK_FALSE(undo.can_redo());
    undo.undo();
    CHECK(undo.now() == "plaster");
}

TEST_CASE("The history drops its oldest values and keeps the newest") {
    Undo<int> undo(0);
    for (int i = 1; i <= 1000; ++i) undo.change(i);
    CHECK(undo.now() == 1000);
    int steps = 0;
    for (; undo.can_undo(); ++steps) undo.undo();
    CHECK(steps == static_cast<int>(Undo<int>::kMaxSteps) - 1);
    CHECK(undo.now() == 1000 - steps);
}
