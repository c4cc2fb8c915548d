#pragma once
// Threads that must run at their moment however busy the machine is: a late packet is a lost one, a late trigger none.

namespace rotunda::capture {

// The calling thread goes before all ordinary ones, where the system allows it (root, CAP_SYS_NICE or a limit
// `rtprio`); otherwise it stays as it is. For threads that wait most of the time.
void make_this_thread_timely();

}  // namespace rotunda::capture
