#include "grouser/terrain/parallel.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace grouser {

namespace {

struct Job {
  int n = 0;
  const std::function<void(int)>* f = nullptr;
  std::atomic<int> next{0};
  std::atomic<int> running{0};
  std::mutex error_mutex;
  int error_index = -1;
  std::exception_ptr error;

  void work() {
    for (int i = next++; i < n; i = next++) {
      try {
        (*f)(i);
      } catch (...) {
        std::lock_guard lock(error_mutex);
        if (error_index < 0 || i < error_index) {
          error_index = i;
          error = std::current_exception();
        }
      }
    }
  }
};

/// Sleeping workers; a job is handed to as many of them as asked for.
class Pool {
 public:
  ~Pool() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (auto& t : threads_) t.join();
  }

  void run(Job& job, int helpers) {
    std::lock_guard one_at_a_time(run_mutex_);
    {
      std::lock_guard lock(mutex_);
      while (static_cast<int>(threads_.size()) < helpers) threads_.emplace_back([this] { loop(); });
      job_ = &job;
      wanted_ = helpers;
      job.running = helpers;
    }
    wake_.notify_all();
    job.work();
    std::unique_lock lock(mutex_);
    done_.wait(lock, [&] { return job.running == 0; });
    job_ = nullptr;
  }

 private:
  void loop() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return stop_ || wanted_ > 0; });
      if (stop_) return;
      --wanted_;
      Job* job = job_;
      lock.unlock();
      job->work();
      lock.lock();
      if (--job->running == 0) done_.notify_all();
    }
  }

  std::mutex run_mutex_, mutex_;
  std::condition_variable wake_, done_;
  std::vector<std::thread> threads_;
  Job* job_ = nullptr;
  int wanted_ = 0;
  bool stop_ = false;
};

Pool& pool() {
  static Pool p;
  return p;
}

thread_local bool inside = false;

}  // namespace

void parallel_for(int n, int threads, const std::function<void(int)>& f) {
  // A nested call runs in place: the pool serves one job at a time.
  if (threads <= 1 || n <= 1 || inside) {
    for (int i = 0; i < n; ++i) f(i);
    return;
  }
  Job job;
  job.n = n;
  const std::function<void(int)> guarded = [&f](int i) {
    inside = true;
    struct Reset {
      ~Reset() { inside = false; }
    } reset;
    f(i);
  };
  job.f = &guarded;
  pool().run(job, std::min(threads, n) - 1);
  if (job.error) std::rethrow_exception(job.error);
}

}  // namespace grouser
