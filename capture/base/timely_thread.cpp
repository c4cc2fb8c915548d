#include "capture/base/timely_thread.h"

#include <pthread.h>

namespace rotunda::capture {

void make_this_thread_timely() {
  constexpr sched_param priority{.sched_priority = 10};  // far below the kernel's own threads
  pthread_setschedparam(pthread_self(), SCHED_RR, &priority);
}

}  // namespace rotunda::capture
