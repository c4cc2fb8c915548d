/* Opens the camera at an address as any program does that trusts what it finds there: Aravis alone, without this
 * house's look at the description, then reads the camera's Width and prints it. Exit codes: 0 read, 4 refused by Aravis
 * itself; else the signal that ended it. Within 1 GiB of memory, 1 s of processor time, 20 s in all and 8 MiB of stack,
 * so that whatever comes of it stays here. */
#include <arv.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

static void limit(__rlimit_resource_t resource, rlim_t most) {
  const struct rlimit limits = {most, most};
  setrlimit(resource, &limits);
}

static int refused(GError* error) {
  fprintf(stderr, "%s\n", error ? error->message : "no camera");
  g_clear_error(&error);
  return 4;
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, 1);
  limit(RLIMIT_STACK, 8 << 20);
  limit(RLIMIT_AS, 1 << 30);
  alarm(20);
  GError* error = NULL;
  ArvCamera* camera = arv_camera_new(argv[1], &error);
  if (!camera) return refused(error);
  const gint64 width = arv_camera_get_integer(camera, "Width", &error);
  g_object_unref(camera);
  if (error) return refused(error);
  printf("%lld\n", (long long)width);
  return 0;
}
