/* Preloaded into a program: the disk under its .mkv files fails or is slow, as the environment says.
   FAILING_DISK_WRITE_AFTER=N  the Nth write and all later ones fail with EIO
   FAILING_DISK_FULL_AFTER=N   likewise with ENOSPC, the first of them after half of its bytes
   FAILING_DISK_SYNC_AFTER=N   the Nth fdatasync and all later ones fail with EIO
   FAILING_DISK_DELAY_US=T     every write takes so much longer
   FAILING_DISK_TELLS_SYNCS=1  nothing fails, and every fdatasync is told
   FAILING_DISK_TOLD=FILE      gets a byte whenever something was done */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static long number(const char* name) {
  const char* text = getenv(name);
  return text ? atol(text) : 0;
}

static int is_take_file(int fd) {
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  return length > 4 && memcmp(path + length - 4, ".mkv", 4) == 0;
}

static void tell(void) {
  const char* file = getenv("FAILING_DISK_TOLD");
  const int fd = file ? open(file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644) : -1;
  if (fd < 0) return;
  syscall(SYS_write, fd, "x", 1);
  close(fd);
}

static int due(const char* name, long* calls) {
  const long after = number(name);
  return after > 0 && __atomic_add_fetch(calls, 1, __ATOMIC_SEQ_CST) >= after;
}

ssize_t write(int fd, const void* bytes, size_t size) {
  static long calls, calls_until_full, halves;
  if (!is_take_file(fd)) return syscall(SYS_write, fd, bytes, size);
  const long delay = number("FAILING_DISK_DELAY_US");
  if (delay > 0) {
    tell();
    usleep((useconds_t)delay);
  }
  if (due("FAILING_DISK_WRITE_AFTER", &calls)) {
    tell();
    errno = EIO;
    return -1;
  }
  if (due("FAILING_DISK_FULL_AFTER", &calls_until_full)) {
    tell();
    if (size > 1 && __atomic_fetch_add(&halves, 1, __ATOMIC_SEQ_CST) == 0)
      return syscall(SYS_write, fd, bytes, size / 2);
    errno = ENOSPC;
    return -1;
  }
  return syscall(SYS_write, fd, bytes, size);
}

int fdatasync(int fd) {
  static long calls;
  if (is_take_file(fd) && number("FAILING_DISK_TELLS_SYNCS") > 0) tell();
  if (is_take_file(fd) && due("FAILING_DISK_SYNC_AFTER", &calls)) {
    tell();
    errno = EIO;
    return -1;
  }
  return (int)syscall(SYS_fdatasync, fd);
}
