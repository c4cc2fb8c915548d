#include "firmware/trigger_box/trigger_box.h"

#include <string.h>

static uint64_t load(const uint8_t* from, unsigned bytes) {
  uint64_t value = 0;
  for (unsigned i = 0; i < bytes; ++i) value |= (uint64_t)from[i] << (8 * i);
  return value;
}

static void store(uint8_t* to, unsigned bytes, uint64_t value) {
  for (unsigned i = 0; i < bytes; ++i) to[i] = (uint8_t)(value >> (8 * i));
}

static uint32_t all_lines(const struct trigger_box* box) {
  return (uint32_t)((1ull << box->lines) - 1);
}

/* Whole steps of the hardware's timer; ranges keep the product far below 2^64. */
static uint64_t in_steps(const struct trigger_box* box, uint64_t ns) {
  const uint64_t steps = (ns * 1000 + box->step_ps / 2) / box->step_ps;
  return steps * box->step_ps / 1000;
}

static void put_line(struct trigger_box* box, unsigned line, bool active, uint64_t at_ns) {
  box->set_line(box->context, line, active != (((box->active_low >> line) & 1) != 0), at_ns);
}

static void rest_lines(struct trigger_box* box, uint64_t at_ns) {
  for (unsigned line = 0; line < box->lines; ++line) put_line(box, line, false, at_ns);
}

static void push_event(struct trigger_box* box, uint8_t code, uint32_t value32, uint64_t at_ns, uint64_t pulses,
                       uint64_t value64) {
  if (box->waiting == TRIGGER_BOX_EVENTS) {
    box->oldest = (box->oldest + 1) % TRIGGER_BOX_EVENTS;
    --box->waiting;
    ++box->lost;
  }
  uint8_t* to = box->event[(box->oldest + box->waiting++) % TRIGGER_BOX_EVENTS];
  memset(to, 0, TRIGGER_BOX_MESSAGE_BYTES);
  to[0] = code;
  to[3] = (uint8_t)box->state;
  store(to + 4, 4, value32);
  store(to + 8, 8, at_ns);
  store(to + 16, 8, pulses);
  store(to + 24, 8, value64);
}

void trigger_box_init(struct trigger_box* box, unsigned lines, uint64_t step_ps, trigger_box_set_line set_line,
                      void* context) {
  memset(box, 0, sizeof *box);
  box->lines = lines > TRIGGER_BOX_MAX_LINES ? TRIGGER_BOX_MAX_LINES : lines;
  box->step_ps = step_ps ? step_ps : 1000;
  box->set_line = set_line;
  box->context = context;
  box->period_ns = in_steps(box, 40000000);
  box->width_ns = in_steps(box, 1000000);
  box->enabled = all_lines(box);
  rest_lines(box, 0);
}

/* --- commands ---------------------------------------------------------------------------------------------------- */

static enum trigger_box_status set_duration(struct trigger_box* box, uint64_t* setting, uint64_t* value, uint64_t low,
                                            uint64_t high) {
  if (*value < low || *value > high) return TRIGGER_BOX_OUT_OF_RANGE;
  *value = *setting = in_steps(box, *value);
  return TRIGGER_BOX_OK;
}

static enum trigger_box_status set_lines(struct trigger_box* box, uint32_t enabled, uint64_t active_low,
                                         uint64_t now_ns) {
  if ((enabled & ~all_lines(box)) || (active_low & ~(uint64_t)all_lines(box))) return TRIGGER_BOX_OUT_OF_RANGE;
  box->enabled = enabled;
  box->active_low = (uint32_t)active_low;
  rest_lines(box, now_ns);
  return TRIGGER_BOX_OK;
}

static enum trigger_box_status start(struct trigger_box* box, uint64_t* at_ns, uint64_t now_ns) {
  uint64_t longest = 0;
  for (unsigned line = 0; line < box->lines; ++line)
    if ((box->enabled >> line) & 1 && box->delay_ns[line] > longest) longest = box->delay_ns[line];
  if (!box->enabled || box->width_ns + longest >= box->period_ns) return TRIGGER_BOX_DOES_NOT_FIT;
  if (*at_ns == 0) *at_ns = now_ns + box->period_ns;
  if (*at_ns <= now_ns) return TRIGGER_BOX_TOO_LATE;
  if (*at_ns - now_ns > TRIGGER_BOX_MAX_START_AHEAD_NS) return TRIGGER_BOX_OUT_OF_RANGE;
  box->first_ns = *at_ns;
  box->pulse = box->begun = 0;
  box->risen = box->fallen = 0;
  box->stopping = false;
  box->state = TRIGGER_BOX_SCHEDULED;
  return TRIGGER_BOX_OK;
}

static void end_train(struct trigger_box* box, enum trigger_box_end why, uint64_t at_ns) {
  box->state = TRIGGER_BOX_IDLE;
  push_event(box, TRIGGER_BOX_DONE, (uint32_t)why, at_ns, box->begun, 0);
}

static void stop(struct trigger_box* box, enum trigger_box_end why, uint64_t now_ns) {
  if (box->state == TRIGGER_BOX_IDLE) return;
  if (!box->risen) { /* between two pulses */
    end_train(box, why, now_ns);
  } else {
    box->stopping = true;
    box->why = why;
  }
}

static enum trigger_box_status obey(struct trigger_box* box, const uint8_t* message, uint64_t now_ns, uint32_t* value32,
                                    uint64_t* value64) {
  const uint64_t line = load(message + 2, 2);
  const bool idle = box->state == TRIGGER_BOX_IDLE;
  switch (message[0]) {
    case TRIGGER_BOX_HELLO:
      *value32 = (uint32_t)TRIGGER_BOX_PROTOCOL << 16 | box->lines;
      *value64 = box->step_ps;
      return TRIGGER_BOX_OK;
    case TRIGGER_BOX_STATUS:
      *value32 = box->risen & ~box->fallen;
      *value64 = box->lost;
      return TRIGGER_BOX_OK;
    case TRIGGER_BOX_STOP:
      stop(box, TRIGGER_BOX_STOPPED, now_ns);
      return TRIGGER_BOX_OK;
    case TRIGGER_BOX_SET_PERIOD:
      return !idle ? TRIGGER_BOX_BUSY
                   : set_duration(box, &box->period_ns, value64, TRIGGER_BOX_MIN_PERIOD_NS, TRIGGER_BOX_MAX_PERIOD_NS);
    case TRIGGER_BOX_SET_WIDTH:
      return !idle ? TRIGGER_BOX_BUSY
                   : set_duration(box, &box->width_ns, value64, TRIGGER_BOX_MIN_WIDTH_NS, TRIGGER_BOX_MAX_PERIOD_NS);
    case TRIGGER_BOX_SET_COUNT:
      if (!idle) return TRIGGER_BOX_BUSY;
      box->count = *value64;
      return TRIGGER_BOX_OK;
    case TRIGGER_BOX_SET_DELAY:
      if (!idle) return TRIGGER_BOX_BUSY;
      if (line >= box->lines) return TRIGGER_BOX_OUT_OF_RANGE;
      return set_duration(box, &box->delay_ns[line], value64, 0, TRIGGER_BOX_MAX_DELAY_NS);
    case TRIGGER_BOX_SET_LINES:
      return !idle ? TRIGGER_BOX_BUSY : set_lines(box, *value32, *value64, now_ns);
    case TRIGGER_BOX_START:
      return !idle ? TRIGGER_BOX_BUSY : start(box, value64, now_ns);
    default:
      return TRIGGER_BOX_UNKNOWN_OPCODE;
  }
}

void trigger_box_command(struct trigger_box* box, const uint8_t* message, size_t bytes, uint64_t now_ns,
                         uint8_t* reply) {
  enum trigger_box_status status = TRIGGER_BOX_BAD_MESSAGE;
  uint32_t value32 = 0;
  uint64_t value64 = 0;
  trigger_box_advance(box, now_ns);
  memset(reply, 0, TRIGGER_BOX_MESSAGE_BYTES);
  reply[0] = TRIGGER_BOX_REPLY;
  if (bytes == TRIGGER_BOX_MESSAGE_BYTES) {
    box->heard_ns = now_ns;
    value32 = (uint32_t)load(message + 4, 4);
    value64 = load(message + 8, 8);
    status = obey(box, message, now_ns, &value32, &value64);
    reply[0] = (uint8_t)(message[0] | TRIGGER_BOX_REPLY);
    reply[1] = message[1];
  }
  reply[2] = (uint8_t)status;
  reply[3] = (uint8_t)box->state;
  store(reply + 4, 4, value32);
  store(reply + 8, 8, now_ns);
  store(reply + 16, 8, box->begun);
  store(reply + 24, 8, value64);
}

/* --- the pulse train --------------------------------------------------------------------------------------------- */

static uint64_t moment(const struct trigger_box* box) {
  return box->first_ns + box->pulse * box->period_ns;
}

/* The next edge of the pulse under way, or the first of the one to come. */
static uint64_t find_edge(const struct trigger_box* box, unsigned* line) {
  uint64_t next = UINT64_MAX;
  for (unsigned i = 0; i < box->lines; ++i) {
    if (!((box->enabled >> i) & 1) || (box->fallen >> i) & 1) continue;
    const uint64_t rise = moment(box) + box->delay_ns[i];
    const uint64_t at = (box->risen >> i) & 1 ? rise + box->width_ns : rise;
    if (at < next) {
      next = at;
      *line = i;
    }
  }
  return next;
}

static bool host_is_silent(const struct trigger_box* box, uint64_t now_ns) {
  return box->count == 0 && now_ns > box->heard_ns && now_ns - box->heard_ns > TRIGGER_BOX_HOST_TIMEOUT_NS;
}

static void begin_pulse(struct trigger_box* box, uint64_t edge_ns, uint64_t now_ns) {
  box->state = TRIGGER_BOX_RUNNING;
  push_event(box, TRIGGER_BOX_PULSE, 0, moment(box), box->begun, now_ns - edge_ns);
  ++box->begun;
}

static void end_pulse(struct trigger_box* box, uint64_t edge_ns) {
  box->risen = box->fallen = 0;
  ++box->pulse;
  if (box->stopping)
    end_train(box, box->why, edge_ns);
  else if (box->count && box->begun == box->count)
    end_train(box, TRIGGER_BOX_COUNT_REACHED, edge_ns);
}

static void do_edge(struct trigger_box* box, unsigned line, uint64_t edge_ns, uint64_t now_ns) {
  const uint32_t bit = 1u << line;
  if (!(box->risen & bit)) {
    if (!box->risen) begin_pulse(box, edge_ns, now_ns);
    box->risen |= bit;
    put_line(box, line, true, edge_ns);
    return;
  }
  box->fallen |= bit;
  put_line(box, line, false, edge_ns);
  if (box->fallen == box->enabled) end_pulse(box, edge_ns);
}

bool trigger_box_next_edge(const struct trigger_box* box, uint64_t* at_ns) {
  unsigned line = 0;
  if (box->state == TRIGGER_BOX_IDLE) return false;
  *at_ns = find_edge(box, &line);
  return true;
}

void trigger_box_advance(struct trigger_box* box, uint64_t now_ns) {
  while (box->state != TRIGGER_BOX_IDLE) {
    unsigned line = 0;
    const uint64_t edge_ns = find_edge(box, &line);
    if (!box->risen && host_is_silent(box, edge_ns < now_ns ? edge_ns : now_ns)) {
      end_train(box, TRIGGER_BOX_HOST_SILENT, now_ns);
      return;
    }
    if (edge_ns > now_ns) return;
    do_edge(box, line, edge_ns, now_ns);
  }
}

bool trigger_box_pop_event(struct trigger_box* box, uint8_t* message) {
  if (!box->waiting) return false;
  memcpy(message, box->event[box->oldest], TRIGGER_BOX_MESSAGE_BYTES);
  box->oldest = (box->oldest + 1) % TRIGGER_BOX_EVENTS;
  --box->waiting;
  return true;
}

void trigger_box_unplugged(struct trigger_box* box) {
  box->state = TRIGGER_BOX_IDLE;
  box->risen = box->fallen = 0;
  box->stopping = false;
  box->waiting = 0;
  rest_lines(box, 0);
}
