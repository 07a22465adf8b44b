#include "engine/base/worker_pool.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

using aula::WorkerPool;

TEST_CASE("a worker pool does every job once, with any number of threads") {
    for (const int threads : {1, 2, 5}) {
        WorkerPool pool(threads);
        for (const std::size_t count : {0U, 1U, 2U, 1000U}) {
            std::vector<std::atomic<int>> done(count);
            pool.run(count, [&](std::size_t i) { ++done[i]; });
            for (const auto& times : done) CHECK(times == 1);
        }
    }
}

TEST_CASE("a worker pool does all jobs whether its threads are awake or asleep") {
    for (const int threads : {2, 5}) {
        WorkerPool pool(threads);
        std::size_t sum = 0;
        std::size_t expected = 0;
        for (std::size_t round = 0; round < 10000; ++round) {
            std::vector<std::size_t> done(2 + round % 7);
            pool.run(done.size(), [&](std::size_t i) { done[i] += round + i; });
            for (std::size_t i = 0; i < done.size(); ++i) {
                sum += done[i];
                expected += round + i;
            }
            if (round % 100 != 0) continue;
            // Shorter and longer than a thread stays awake.
            std::this_thread::sleep_for(std::chrono::microseconds(50 + round % 1000));
            // All threads take part: each job waits for the others.
            std::atomic<int> begun = 0;
            pool.run(static_cast<std::size_t>(threads), [&](std::size_t) {
                ++begun;
                while (begun < threads) std::this_thread::yield();
            });
        }
        CHECK(sum == expected);
    }
}

TEST_CASE("a worker pool has the given number of threads, the caller's included") {
    for (const int threads : {1, 2, 5}) CHECK(WorkerPool(threads).threads() == threads);
    // One thread is the caller's.
    WorkerPool pool(1);
    const auto caller = std::this_thread::get_id();
    pool.run(100, [&](std::size_t) { CHECK(std::this_thread::get_id() == caller); });
}

TEST_CASE("an exception of a job reaches the caller, and the pool can be used again") {
    for (const int threads : {1, 2, 5}) {
        WorkerPool pool(threads);
        // Thrown on the thread that takes the job, the caller's or another.
        for (const std::size_t bad : {0U, 1U, 500U, 999U}) {
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
