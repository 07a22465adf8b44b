#include "apps/session/live/change_preparer.h"

#include <catch2/catch.hpp>
#include <functional>
#include <mutex>

#include "aula/exception.h"
#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

using namespace aula;

namespace {

/// A preparer whose changes begin by a function of the test, and which notes how they begin.
class Preparation {
 public:
    using Begin = std::function<void(Preparation&, std::uint64_t number)>;

    explicit Preparation(Begin begin)
        : changes_(48000, {.reusable = [] { return Reusable{}; },
                           .apply_controls = [](PreparedScene&) {},
                           .begin =
                               [this, begin = std::move(begin)](
                                   std::unique_ptr<PreparedScene> prepared, std::uint64_t number) {
                                   begin(*this, number);
                                   if (number == 2) second_anew_ = prepared->starts_anew;
                               }}) {
        options_.output = OutputFormat::mono;
        scene_.simulation.ir_length_s = 0.1F;
    }

    ChangePreparer& changes() { return changes_; }
    std::uint64_t request(bool anew) { return changes_.request(scene_, options_, anew); }

    /// Whether the second change begins anew, once nothing is being prepared.
    std::optional<bool> second_anew() {
        if (!test::eventually([&] { return !changes_.status().preparing; })) return {};
        return second_anew_;
    }

 private:
    Scene scene_ = test::free_field({1, 0, 0});
    SessionOptions options_;
    std::optional<bool> second_anew_;
    ChangePreparer changes_;  ///< ends before the members that its thread uses
};

}  // namespace

TEST_CASE("A change continues a new scene that has begun, and begins one that failed to") {
    // The second change is requested while the first one begins, and so does not replace it.
    Preparation begun([](Preparation& now, std::uint64_t number) {
        now.changes().set_begun();
        if (number == 1) now.request(false);
    });
    begun.request(true);
    CHECK(begun.second_anew() == false);
    CHECK(begun.changes().status().failed == 0);

    Preparation failed([](Preparation& now, std::uint64_t number) {
        if (number > 1) return now.changes().set_begun();
        now.request(false);
        throw Failure("no memory");
    });
    failed.request(true);
    CHECK(failed.second_anew() == true);
    CHECK(failed.changes().status().failed == 1);
    CHECK(failed.changes().status().error.empty());
}
