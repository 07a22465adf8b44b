#include "engine/base/worker_pool.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>

using aula::WorkerPool;

TEST_CASE("a pool of any number of threads does each job once") {
    for (const int threads : {1, 2, 5}) {
        WorkerPool pool(threads);
        std::vector<std::atomic<int>> done(1000);
        pool.run(done.size(), [&](std::size_t i) { ++done[i]; });
        for (const auto& count : done) REQUIRE(count == 1);
    }
}

TEST_CASE("an exception of a job reaches the caller, and the pool works on") {
    for (const int threads : {1, 2, 5}) {
        WorkerPool pool(threads);
        // Thrown by whichever thread takes the job, the caller's or another.
        for (const std::size_t bad : {0, 1, 500, 999}) {
            const auto job = [&](std::size_t i) {
                if (i == bad) throw std::runtime_error("job");
            };
            CHECK_THROWS_WITH(pool.run(1000, job), "job");
        }
        const auto all_fail = [](std::size_t) { throw std::runtime_error("each"); };
        CHECK_THROWS_WITH(pool.run(1000, all_fail), "each");
        std::atomic<int> count = 0;
        pool.run(1000, [&](std::size_t) { ++count; });
        CHECK(count == 1000);
    }
}
