/* A trigger box's state machine: commands and time go in, replies, events and line levels come out. C11, no heap, no
 * clock, no input or output of its own, so that a microcontroller's firmware and the emulator in the tests run the same
 * code. Call from one context at a time.
 *
 * Firmware: on a bulk OUT message call trigger_box_command() and send the reply; set a timer to trigger_box_next_edge()
 * and in its interrupt call trigger_box_advance(); send what trigger_box_pop_event() gives whenever the IN endpoint is
 * free. `now` never runs backwards. */
#ifndef ROTUNDA_TRIGGER_BOX_H
#define ROTUNDA_TRIGGER_BOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/trigger_box/trigger_box_protocol.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TRIGGER_BOX_EVENTS 64 /* kept while the host does not fetch them */

/* Sets a line's level; `at` is the edge's nominal time. */
typedef void (*trigger_box_set_line)(void* context, unsigned line, bool high, uint64_t at_ns);

struct trigger_box {
  /* the hardware */
  unsigned lines;
  uint64_t step_ps;
  trigger_box_set_line set_line;
  void* context;
  /* settings */
  uint64_t period_ns, width_ns, count, delay_ns[TRIGGER_BOX_MAX_LINES];
  uint32_t enabled, active_low;
  /* the train */
  enum trigger_box_state state;
  uint64_t first_ns, pulse, begun, heard_ns;
  uint32_t risen, fallen; /* lines of the pulse under way */
  bool stopping;
  enum trigger_box_end why;
  /* events */
  uint8_t event[TRIGGER_BOX_EVENTS][TRIGGER_BOX_MESSAGE_BYTES];
  unsigned oldest, waiting;
  uint64_t lost;
};

/* `lines` at most TRIGGER_BOX_MAX_LINES; `step_ps` of the hardware's timer. All lines go to rest. */
void trigger_box_init(struct trigger_box* box, unsigned lines, uint64_t step_ps, trigger_box_set_line set_line,
                      void* context);

/* Writes the reply of TRIGGER_BOX_MESSAGE_BYTES. Any bytes are welcome. */
void trigger_box_command(struct trigger_box* box, const uint8_t* message, size_t bytes, uint64_t now_ns,
                         uint8_t* reply);

/* When trigger_box_advance() has something to do next; false: never, unless told. */
bool trigger_box_next_edge(const struct trigger_box* box, uint64_t* at_ns);

/* Does every edge that is due. */
void trigger_box_advance(struct trigger_box* box, uint64_t now_ns);

/* The oldest event; false if there is none. */
bool trigger_box_pop_event(struct trigger_box* box, uint8_t* message);

/* The host has gone (USB reset, unplugged): the train ends, what was not fetched is forgotten. */
void trigger_box_unplugged(struct trigger_box* box);

#ifdef __cplusplus
}
#endif
#endif
