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

TEST_CASE(
    "a worker pool does all jobs in rounds without and with pauses for its threads to sleep") {
    for (const int threads : {2, 5}) {
        WorkerPool pool(threads);
        std::size_t sum = 0;
        std::size_t expected = 0;
        std::size_t elsewhere = 0;
        for (std::size_t round = 0; round < 20000; ++round) {
            const std::size_t count = 2 + round % 7;
            std::vector<std::size_t> done(count);
            std::vector<char> by_worker(count);
            const auto caller = std::this_thread::get_id();
            pool.run(count, [&](std::size_t i) {
                done[i] += round + i;
                by_worker[i] = std::this_thread::get_id() != caller ? 1 : 0;
            });
            for (std::size_t i = 0; i < count; ++i) {
                sum += done[i];
                expected += round + i;
                elsewhere += by_worker[i] != 0 ? 1U : 0U;
            }
            // Around the time after which a thread sleeps, and beyond it.
            if (round % 100 == 0)
                std::this_thread::sleep_for(std::chrono::microseconds(50 + round % 1000));
        }
        CHECK(sum == expected);
        CHECK(elsewhere > 0);
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
