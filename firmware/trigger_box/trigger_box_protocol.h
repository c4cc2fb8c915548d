/* The messages between a host and a trigger box, over two USB bulk endpoints of a vendor-class interface.
 * docs/trigger-box.md is the description; this header is shared by firmware, emulator and host.
 * Every message is 32 bytes, little-endian. Times are nanoseconds of the box's own clock, which starts at power-up. */
#ifndef ROTUNDA_TRIGGER_BOX_PROTOCOL_H
#define ROTUNDA_TRIGGER_BOX_PROTOCOL_H

#include <stdint.h>

#define TRIGGER_BOX_VENDOR_ID 0x1209 /* pid.codes */
#define TRIGGER_BOX_PRODUCT_ID 0x7472
#define TRIGGER_BOX_PROTOCOL 1
#define TRIGGER_BOX_ENDPOINT_OUT 0x01
#define TRIGGER_BOX_ENDPOINT_IN 0x81
#define TRIGGER_BOX_MESSAGE_BYTES 32
#define TRIGGER_BOX_MAX_LINES 8

/* Host to box. Bytes 0 opcode, 1 tag (any; comes back in the reply), 2-3 line, 4-7 value32, 8-15 value64, rest 0. */
enum trigger_box_opcode {
  TRIGGER_BOX_HELLO = 1,      /* reply: value32 protocol << 16 | lines, value64 the clock's step in picoseconds */
  TRIGGER_BOX_SET_PERIOD = 2, /* value64 ns; reply: value64 what it really is, whole steps of the clock */
  TRIGGER_BOX_SET_WIDTH = 3,  /* value64 ns; reply likewise */
  TRIGGER_BOX_SET_COUNT = 4,  /* value64 pulses; 0: until stopped */
  TRIGGER_BOX_SET_DELAY = 5,  /* line, value64 ns after the pulse's moment; reply likewise */
  TRIGGER_BOX_SET_LINES = 6,  /* value32: bit n set: line n pulses; value64: bit n set: line n is active low */
  TRIGGER_BOX_START = 7,      /* value64: moment of pulse 0, 0: soon; reply: value64 the moment */
  TRIGGER_BOX_STOP = 8,       /* the pulse under way ends as it should; no more follow */
  TRIGGER_BOX_STATUS = 9,     /* reply: value32 levels of the lines, value64 events lost */
};

/* Box to host: replies (opcode | 0x80) and events. Bytes 0 code, 1 tag, 2 status, 3 state, 4-7 value32, 8-15 the box's
 * time when it answered or, of an event, the pulse's moment, 16-23 pulses begun since START (an event: the pulse's
 * number, from 0), 24-31 value64. */
#define TRIGGER_BOX_REPLY 0x80
enum trigger_box_event {
  TRIGGER_BOX_PULSE = 0xC0, /* value64: ns by which the first edge came late */
  TRIGGER_BOX_DONE = 0xC1,  /* the train has ended; value32: enum trigger_box_end */
};

enum trigger_box_end { TRIGGER_BOX_COUNT_REACHED = 0, TRIGGER_BOX_STOPPED = 1, TRIGGER_BOX_HOST_SILENT = 2 };

enum trigger_box_status {
  TRIGGER_BOX_OK = 0,
  TRIGGER_BOX_UNKNOWN_OPCODE = 1,
  TRIGGER_BOX_OUT_OF_RANGE = 2,
  TRIGGER_BOX_BUSY = 3,         /* only STOP, STATUS and HELLO while a train runs */
  TRIGGER_BOX_DOES_NOT_FIT = 4, /* width and the longest delay must be shorter than the period */
  TRIGGER_BOX_TOO_LATE = 5,     /* START for a moment that has passed */
  TRIGGER_BOX_BAD_MESSAGE = 6,  /* not 32 bytes */
};

enum trigger_box_state { TRIGGER_BOX_IDLE = 0, TRIGGER_BOX_SCHEDULED = 1, TRIGGER_BOX_RUNNING = 2 };

/* A train that runs until stopped ends when the host has said nothing for so long: a dead host triggers no cameras. */
#define TRIGGER_BOX_HOST_TIMEOUT_NS 3000000000ull

#define TRIGGER_BOX_MIN_PERIOD_NS 100000ull        /* 10 kHz */
#define TRIGGER_BOX_MAX_PERIOD_NS 3600000000000ull /* an hour */
#define TRIGGER_BOX_MIN_WIDTH_NS 1000ull
#define TRIGGER_BOX_MAX_DELAY_NS 1000000000ull
#define TRIGGER_BOX_MAX_START_AHEAD_NS 3600000000000ull

#endif
