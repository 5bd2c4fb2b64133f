/* See stairscan.h. Sentences are tables of fields, used for both reading and writing. */
#include "stairscan.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define TAIL 11u          /* '*', eight digits, CR LF */
#define AFTER_REASONS 57u /* room for the fields after the reasons of a SCAN */
#define STEEPEST 45000    /* 0.001 degrees */

/* Annotations of the form "@" are for Frama-C, which checks them: see `controller/prove`. */
/*@ predicate readable(stairscan_text_t text) =
        text.length <= 0x7FFFFFFF && \valid_read(text.at + (0 .. text.length - 1)); */

/* ---- words ---- */

#define STAIRSCAN_X(name, word, meaning) word,
static const char *const REASONS[] = {STAIRSCAN_REASONS(STAIRSCAN_X)};
#undef STAIRSCAN_X
#define STAIRSCAN_X(name, word, meaning) meaning,
static const char *const MEANINGS[] = {STAIRSCAN_REASONS(STAIRSCAN_X)};
#undef STAIRSCAN_X
#define STAIRSCAN_X(key) key,
static const char *const KEYS[] = {STAIRSCAN_KEYS(STAIRSCAN_X)};
static const char *const MEASURES[] = {STAIRSCAN_MEASURES(STAIRSCAN_X)};
#undef STAIRSCAN_X
static const char *const STATUSES[] = {"ok", "degraded", "fault"};
static const char *const DIRECTIONS[] = {"none", "up", "down"};
static const char *const PLANES[] = {"", "depth", "height"};
static const char *const ENDINGS[] = {"none", "rise", "drop", "obstacle", "unknown"};
/* In the order of enum stairscan_command. */
static const char *const COMMANDS[] = {"start",   "stop",   "scan",        "guard",    "watch", "status",
                                       "version", "crash?", "crash-clear", "selftest", "save",  "update",
                                       "reset",   "get",    "set",         "calibrate", "MOTION"};

/*@ requires \valid_read(words + (0 .. count - 1));
    assigns \nothing; */
static const char *word_at(const char *const *words, size_t count, uint32_t at) {
    return at < count ? words[at] : "";
}

const char *stairscan_reason_word(uint32_t reason) {
    return word_at(REASONS, COUNT(REASONS), reason);
}

const char *stairscan_reason_meaning(uint32_t reason) {
    return word_at(MEANINGS, COUNT(MEANINGS), reason);
}

stairscan_text_t stairscan_text(const char *string) {
    stairscan_text_t text = {string, 0};
    /*@ loop invariant string != \null ==> 0 <= text.length <= strlen(string);
        loop invariant string == \null ==> text.length == 0;
        loop invariant text.at == string;
        loop assigns text.length;
        loop unroll 24; */
    while (string != NULL && string[text.length] != '\0') {
        text.length++;
    }
    return text;
}

/*@ requires readable(text);
    requires valid_read_string(word);
    assigns \nothing;
    ensures \result ==> text.length == strlen(word); */
static bool is_word(stairscan_text_t text, const char *word) {
    size_t k = 0;
    /*@ loop invariant 0 <= k <= text.length && k <= strlen(word);
        loop assigns k;
        loop unroll 24;
        loop variant text.length - k; */
    while (k < text.length && word[k] != '\0' && word[k] == text.at[k]) {
        k++;
    }
    return k == text.length && word[k] == '\0';
}

/* Returns the index of a text among words, or their count. */
/*@ requires readable(text);
    requires count <= 255;
    requires \valid_read(words + (0 .. count - 1));
    assigns \nothing;
    ensures \result <= count; */
static uint32_t find(stairscan_text_t text, const char *const *words, size_t count) {
    uint32_t at = 0;
    /*@ loop invariant 0 <= at <= count;
        loop assigns at;
        loop unroll 80;
        loop variant count - at; */
    while (at < count && !is_word(text, words[at])) {
        at++;
    }
    return at;
}

/*@ assigns \nothing; */
static bool is_printable(char c) {
    return c >= ' ' && c <= '~';
}

/*@ requires length <= 0x7FFFFFFF;
    requires \valid_read(bytes + (0 .. length - 1));
    assigns \nothing; */
static bool are_printable(const char *bytes, size_t length) {
    size_t k = 0;
    /*@ loop invariant 0 <= k <= length;
        loop assigns k;
        loop variant length - k; */
    while (k < length && is_printable(bytes[k])) {
        k++;
    }
    return k == length;
}

/*@ requires readable(text);
    assigns \nothing; */
static bool has_framing(stairscan_text_t text) {
    size_t k = 0;
    /*@ loop invariant 0 <= k <= text.length;
        loop assigns k;
        loop variant text.length - k; */
    while (k < text.length && text.at[k] != '$' && text.at[k] != '*') {
        k++;
    }
    return k < text.length;
}

/* ---- CRC-32 and digits ---- */

uint32_t stairscan_crc32(const char *bytes, size_t length) {
    /* The polynomial 0xEDB88320 times each four-bit value. */
    static const uint32_t table[16] = {
        0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u,
        0x4DB26158u, 0x5005713Cu, 0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu,
        0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};
    uint32_t crc = 0xFFFFFFFFu;
    size_t k;
    /*@ loop invariant 0 <= k <= length;
        loop assigns k, crc;
        loop variant length - k; */
    for (k = 0; k < length; k++) {
        crc ^= (uint8_t)bytes[k];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return ~crc;
}

/*@ assigns \nothing;
    ensures \result <==> '0' <= c <= '9'; */
static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/* Returns the value of a hex digit, or 16. */
/*@ assigns \nothing;
    ensures \result <= 16; */
static uint32_t hex_digit(char c) {
    if (is_digit(c)) {
        return (uint32_t)(c - '0');
    }
    if (c >= 'A' && c <= 'F') {
        return (uint32_t)(c - 'A') + 10u;
    }
    return c >= 'a' && c <= 'f' ? (uint32_t)(c - 'a') + 10u : 16u;
}

/* Reads exactly `count` words of eight hex digits each. */
/*@ requires readable(text);
    requires count <= 3;
    requires \valid(words + (0 .. count - 1));
    assigns words[0 .. count - 1]; */
static bool read_hex(stairscan_text_t text, uint32_t *words, size_t count) {
    size_t k;
    if (text.length != 8 * count) {
        return false;
    }
    /*@ loop invariant 0 <= k <= text.length;
        loop assigns k, words[0 .. count - 1];
        loop unroll 24;
        loop variant text.length - k; */
    for (k = 0; k < text.length; k++) {
        uint32_t digit = hex_digit(text.at[k]);
        uint32_t before = k % 8 == 0 ? 0 : words[k / 8];
        if (digit > 15) {
            return false;
        }
        words[k / 8] = (before << 4) | digit;
    }
    return true;
}

/* Reads a number of at least one digit and at most `largest`. */
/*@ requires readable(text);
    requires \valid(value);
    assigns *value;
    ensures \result ==> *value <= largest; */
static bool read_digits(stairscan_text_t text, uint32_t largest, uint32_t *value) {
    uint64_t sum = 0;
    size_t k;
    /*@ loop invariant 0 <= k <= text.length && 0 <= sum <= largest;
        loop assigns k, sum;
        loop variant text.length - k; */
    for (k = 0; k < text.length; k++) {
        if (!is_digit(text.at[k])) {
            return false;
        }
        sum = 10 * sum + (uint32_t)(text.at[k] - '0');
        if (sum > largest) {
            return false;
        }
    }
    *value = (uint32_t)sum;
    return text.length > 0;
}

/* Removes the first byte if it is `sign`. */
/*@ requires \valid(text);
    requires readable(*text);
    assigns *text;
    ensures readable(*text);
    ensures \result ==> text->length == \old(text->length) - 1 && text->at == \old(text->at) + 1;
    ensures !\result ==> text->length == \old(text->length) && text->at == \old(text->at); */
static bool strip(stairscan_text_t *text, char sign) {
    if (text->length == 0 || text->at[0] != sign) {
        return false;
    }
    text->at++;
    text->length--;
    return true;
}

/*@ requires readable(text);
    requires \valid(value);
    assigns *value;
    ensures \result ==> *value <= largest; */
static bool read_number(stairscan_text_t text, uint32_t largest, uint32_t *value) {
    (void)strip(&text, '+');
    return read_digits(text, largest, value);
}

/* Reads a number as in commands: with an optional sign. */
/*@ requires readable(text);
    requires \valid(value);
    assigns *value;
    ensures \result ==> *value <= largest; */
static bool read_count(stairscan_text_t text, uint32_t largest, uint32_t *value) {
    if (strip(&text, '-')) {
        return read_digits(text, 0, value);
    }
    return read_number(text, largest, value);
}

/*@ requires readable(text);
    requires \valid(pitch);
    assigns *pitch; */
static bool read_pitch(stairscan_text_t text, int32_t *pitch) {
    bool negative = strip(&text, '-');
    uint32_t value = 0;
    if (!negative) {
        (void)strip(&text, '+');
    }
    if (!read_digits(text, STEEPEST, &value)) {
        return false;
    }
    *pitch = negative ? -(int32_t)value : (int32_t)value;
    return true;
}

/* Reads a length: an optional sign, digits, a point, one digit. */
/*@ requires readable(text);
    requires \valid(tenths);
    assigns *tenths; */
static bool read_length(stairscan_text_t text, int32_t *tenths) {
    bool negative = strip(&text, '-');
    stairscan_text_t whole = text;
    uint32_t value = 0;
    uint64_t sum;
    if (text.length < 3 || text.at[text.length - 2] != '.' || !is_digit(text.at[text.length - 1])) {
        return false;
    }
    whole.length -= 2;
    if (!read_digits(whole, INT32_MAX, &value)) {
        return false;
    }
    sum = 10 * (uint64_t)value + (uint32_t)(text.at[text.length - 1] - '0');
    if (sum > INT32_MAX) {
        return false;
    }
    *tenths = negative ? -(int32_t)sum : (int32_t)sum;
    return true;
}

/*@ requires readable(text);
    requires \valid(tenths);
    assigns *tenths; */
static bool read_percent(stairscan_text_t text, int32_t *tenths) {
    return read_length(text, tenths) && *tenths >= 0 && *tenths <= 1000;
}

/* Reads reasons joined by '+'; empty ones are ignored. */
/*@ requires readable(text);
    requires \valid(reasons);
    assigns *reasons; */
static bool read_reasons(stairscan_text_t text, uint64_t *reasons) {
    size_t begin = 0;
    size_t end;
    *reasons = 0;
    /*@ loop invariant 0 <= begin <= end <= text.length + 1;
        loop assigns begin, end, *reasons;
        loop variant text.length + 1 - end; */
    for (end = 0; end <= text.length; end++) {
        if (end == text.length || text.at[end] == '+') {
            stairscan_text_t word = {text.at + begin, end - begin};
            uint32_t reason = find(word, REASONS, COUNT(REASONS));
            if (word.length > 0 && reason == COUNT(REASONS)) {
                return false;
            }
            if (word.length > 0) {
                *reasons |= (uint64_t)1 << reason;
            }
            begin = end + 1;
        }
    }
    return true;
}

/* ---- the table of sentences ---- */

/* Type of a field, with the type of its member in stairscan_sentence_t. */
enum type {
    TEXT,        /* stairscan_text_t */
    MAY_TEXT,    /* stairscan_text_t; may be missing together with its comma and all fields behind it */
    REST,        /* stairscan_text_t: the rest of the line, including commas */
    U8,          /* uint32_t, at most 255 */
    U16,         /* uint32_t, at most 65535 */
    U32,         /* uint32_t */
    TIME,        /* stairscan_time_t, or empty */
    HASH,        /* uint32_t, eight hex digits */
    MAY_HASH,    /* stairscan_word_t, or empty */
    SERIAL,      /* three words of eight hex digits */
    LENGTH,      /* int32_t */
    MAY_LENGTH,  /* stairscan_optional_t, or empty */
    PERCENT,     /* uint32_t */
    MAY_PERCENT, /* stairscan_optional_t, or empty */
    PITCH,       /* stairscan_optional_t, or empty */
    STATUS,      /* uint32_t */
    DIRECTION,   /* uint32_t */
    ENDING,      /* uint32_t */
    REASON,      /* uint32_t */
    REASON_SET,  /* uint64_t */
    MAY_PLANE,   /* uint32_t; may be missing together with its comma and all fields behind it, else empty */
    FROM_LENGTH, /* stairscan_optional_t, not empty; may be missing together with its comma and all behind it */
    LAST_LENGTH  /* stairscan_optional_t, not empty; may be missing with the field before it */
};

struct field {
    const char *name;
    enum type type;
    size_t at;
};

struct form {
    const char *name;
    uint32_t kind;
    const struct field *fields;
    size_t count;
};

#define F(name, type, place) {name, type, offsetof(stairscan_sentence_t, as.place)}

static const struct field SCAN[] = {
    F("scan", U32, scan.scan),
    F("status", STATUS, scan.status),
    F("direction", DIRECTION, scan.direction),
    F("steps", U8, scan.steps),
    F("lost-rows", U16, scan.lost_rows),
    F("reasons", REASON_SET, scan.reasons),
    F("horizon", MAY_LENGTH, scan.horizon),
    F("confidence", MAY_PERCENT, scan.confidence),
    F("maybes", U8, scan.maybes),
    F("settings", HASH, scan.settings),
    F("drops", U8, scan.drops),
    F("plane", MAY_PLANE, scan.plane),
    F("slope-from", FROM_LENGTH, scan.slope_from),
    F("slope", LAST_LENGTH, scan.slope)};
static const struct field STEP[] = {
    F("scan", U32, step.scan),
    F("index", U8, step.index),
    F("count", U8, step.count),
    F("distance", LENGTH, step.distance),
    F("height", LENGTH, step.height),
    F("tread", MAY_LENGTH, step.tread),
    F("riser", MAY_LENGTH, step.riser),
    F("distance-sigma", LENGTH, step.distance_sigma),
    F("height-sigma", LENGTH, step.height_sigma),
    F("quality", U8, step.quality)};
static const struct field DROP[] = {
    F("scan", U32, drop.scan),
    F("distance", LENGTH, drop.distance),
    F("distance-sigma", LENGTH, drop.distance_sigma),
    F("depth", MAY_LENGTH, drop.depth),
    F("probability", PERCENT, drop.probability)};
static const struct field MAYBE[] = {
    F("scan", U32, maybe.scan),
    F("index", U8, maybe.index),
    F("count", U8, maybe.count),
    F("distance", LENGTH, maybe.distance),
    F("height", LENGTH, maybe.height),
    F("probability", PERCENT, maybe.probability)};
static const struct field GUARD[] = {
    F("sweep", U32, guard.sweep),
    F("status", STATUS, guard.status),
    F("free", MAY_LENGTH, guard.free),
    F("ending", ENDING, guard.ending),
    F("confidence", PERCENT, guard.confidence),
    F("reasons", REASON_SET, guard.reasons)};
static const struct field BOOT[] = {
    F("version", TEXT, boot.version),
    F("revision", TEXT, boot.revision),
    F("reset", TEXT, boot.reset),
    F("clock", TEXT, boot.clock),
    F("boots", U32, boot.boots),
    F("settings", HASH, boot.settings),
    F("serial", SERIAL, boot.serial),
    F("second-memory", MAY_TEXT, boot.second_memory),
    F("option-bytes", MAY_HASH, boot.option_bytes),
    F("pc", MAY_HASH, boot.crash.pc),
    F("lr", MAY_HASH, boot.crash.lr),
    F("cfsr", MAY_HASH, boot.crash.cfsr),
    F("address", MAY_HASH, boot.crash.address),
    F("place", MAY_HASH, boot.crash.place)};
static const struct field STAT[] = {
    F("state", TEXT, stat.state),
    F("clock", TEXT, stat.clock),
    F("scans", U32, stat.scans),
    F("estimator", TEXT, stat.estimator),
    F("reasons", REASON_SET, stat.reasons),
    F("motion", TEXT, stat.motion),
    F("motion-faults", U16, stat.motion_faults),
    F("settings", HASH, stat.settings)};
static const struct field LIVE[] = {
    F("state", TEXT, live.state),
    F("scan", U32, live.scan),
    F("uptime", U32, live.uptime_ms),
    F("age", TIME, live.age),
    F("motion", TEXT, live.motion),
    F("motion-faults", U16, live.motion_faults),
    F("refused", U16, live.refused),
    F("port-errors", U16, live.port_errors),
    F("link-errors", U16, live.link_errors)};
static const struct field CONF[] = {F("key", TEXT, conf.key), F("value", TEXT, conf.value)};
static const struct field DONE[] = {F("command", TEXT, done.command)};
static const struct field FAIL[] = {
    F("command", TEXT, fail.command),
    F("field", TEXT, fail.field),
    F("expected", REST, fail.expected)};
static const struct field CRASH[] = {
    F("cause", TEXT, crash.cause),
    F("boot", U32, crash.boot),
    F("pc", MAY_HASH, crash.site.pc),
    F("lr", MAY_HASH, crash.site.lr),
    F("cfsr", MAY_HASH, crash.site.cfsr),
    F("address", MAY_HASH, crash.site.address),
    F("place", MAY_HASH, crash.site.place)};
static const struct field HALT[] = {F("reason", REASON, halt.reason)};

/* In the order of enum stairscan_kind. */
static const struct form FORMS[] = {
    {"SCAN", STAIRSCAN_SCAN, SCAN, COUNT(SCAN)},
    {"STEP", STAIRSCAN_STEP, STEP, COUNT(STEP)},
    {"DROP", STAIRSCAN_DROP, DROP, COUNT(DROP)},
    {"MAYBE", STAIRSCAN_MAYBE, MAYBE, COUNT(MAYBE)},
    {"GUARD", STAIRSCAN_GUARD, GUARD, COUNT(GUARD)},
    {"BOOT", STAIRSCAN_BOOT, BOOT, COUNT(BOOT)},
    {"STAT", STAIRSCAN_STAT, STAT, COUNT(STAT)},
    {"LIVE", STAIRSCAN_LIVE, LIVE, COUNT(LIVE)},
    {"CONF", STAIRSCAN_CONF, CONF, COUNT(CONF)},
    {"DONE", STAIRSCAN_DONE, DONE, COUNT(DONE)},
    {"FAIL", STAIRSCAN_FAIL, FAIL, COUNT(FAIL)},
    {"HALT", STAIRSCAN_HALT, HALT, COUNT(HALT)},
    {"CRASH", STAIRSCAN_CRASH, CRASH, COUNT(CRASH)}};

#define M(name, type, place) {name, type, offsetof(stairscan_motion_t, place)}

static const struct field MOTION[] = {
    M("sequence", U16, sequence), M("travel", LENGTH, travel), M("pitch", PITCH, pitch)};

#define W(name, type, place) {name, type, offsetof(stairscan_calibration_t, place)}

static const struct field CALIBRATION[] = {W("wall", U16, wall_mm), W("date", U32, date)};

/* ---- reading ---- */

/* The rest of a line; empty after its last field. */
struct cursor {
    stairscan_text_t left;
    bool more;
};

/*@ requires \valid(cursor);
    requires \valid(field);
    requires \separated(cursor, field);
    requires readable(cursor->left);
    assigns *cursor, *field;
    ensures readable(cursor->left) && (\result ==> readable(*field));
    ensures !\result ==> field->at == \old(field->at) && field->length == \old(field->length); */
static bool take(struct cursor *cursor, stairscan_text_t *field) {
    size_t length = 0;
    stairscan_text_t *left = &cursor->left;
    if (!cursor->more) {
        return false;
    }
    /*@ loop invariant 0 <= length <= left->length;
        loop assigns length;
        loop variant left->length - length; */
    while (length < left->length && left->at[length] != ',') {
        length++;
    }
    field->at = left->at;
    field->length = length;
    cursor->more = length < left->length;
    if (cursor->more) {
        left->at += length + 1;
        left->length -= length + 1;
    }
    return true;
}

/*@ requires \valid(cursor);
    requires \valid(field);
    requires \separated(cursor, field);
    requires readable(cursor->left);
    assigns *field;
    ensures readable(*field); */
static bool take_rest(struct cursor *cursor, stairscan_text_t *field) {
    *field = cursor->left;
    return cursor->more;
}

/*@ requires readable(text);
    requires \valid(at);
    requires count <= 255;
    requires \valid_read(words + (0 .. count - 1));
    assigns *at; */
static bool store_word(stairscan_text_t text, const char *const *words, size_t count, uint32_t *at) {
    *at = find(text, words, count);
    return *at < count;
}

/*@ requires readable(text);
    requires \valid(optional);
    assigns optional->present, optional->value; */
static bool store_optional(stairscan_text_t text, enum type type, stairscan_optional_t *optional) {
    optional->present = text.length > 0;
    optional->value = 0;
    if (!optional->present) {
        return true;
    }
    switch (type) {
    case MAY_PERCENT:
        return read_percent(text, &optional->value);
    case PITCH:
        return read_pitch(text, &optional->value);
    default:
        return read_length(text, &optional->value);
    }
}

/*@ requires readable(text);
    requires \valid(time);
    assigns *time; */
static bool store_time(stairscan_text_t text, stairscan_time_t *time) {
    time->present = text.length > 0;
    time->ms = 0;
    return !time->present || read_number(text, UINT32_MAX, &time->ms);
}

/*@ requires readable(text);
    requires \valid(word);
    assigns *word; */
static bool store_optional_hash(stairscan_text_t text, stairscan_word_t *word) {
    word->present = text.length > 0;
    word->word = 0;
    return !word->present || read_hex(text, &word->word, 1);
}

/*@ requires readable(text);
    requires \valid(tenths);
    assigns *tenths; */
static bool store_percent(stairscan_text_t text, uint32_t *tenths) {
    int32_t value = 0;
    if (!read_percent(text, &value)) {
        return false;
    }
    *tenths = (uint32_t)value;
    return true;
}

/* Stores a field's value in its member, whose type is given in the table above. */
/*@ requires readable(text);
    assigns ((char *)place)[0 .. sizeof(stairscan_text_t) - 1]; */
static bool store(stairscan_text_t text, enum type type, void *place) {
    switch (type) {
    case TEXT:
    case MAY_TEXT:
    case REST:
        *(stairscan_text_t *)place = text;
        return true;
    case U8:
        return read_number(text, UINT8_MAX, (uint32_t *)place);
    case U16:
        return read_number(text, UINT16_MAX, (uint32_t *)place);
    case U32:
        return read_number(text, UINT32_MAX, (uint32_t *)place);
    case TIME:
        return store_time(text, (stairscan_time_t *)place);
    case HASH:
        return read_hex(text, (uint32_t *)place, 1);
    case MAY_HASH:
        return store_optional_hash(text, (stairscan_word_t *)place);
    case SERIAL:
        return read_hex(text, (uint32_t *)place, 3);
    case LENGTH:
        return read_length(text, (int32_t *)place);
    case MAY_LENGTH:
    case FROM_LENGTH:
    case LAST_LENGTH:
    case MAY_PERCENT:
    case PITCH:
        return store_optional(text, type, (stairscan_optional_t *)place);
    case PERCENT:
        return store_percent(text, (uint32_t *)place);
    case STATUS:
        return store_word(text, STATUSES, COUNT(STATUSES), (uint32_t *)place);
    case DIRECTION:
        return store_word(text, DIRECTIONS, COUNT(DIRECTIONS), (uint32_t *)place);
    case ENDING:
        return store_word(text, ENDINGS, COUNT(ENDINGS), (uint32_t *)place);
    case REASON:
        return store_word(text, REASONS, COUNT(REASONS), (uint32_t *)place);
    case REASON_SET:
        return read_reasons(text, (uint64_t *)place);
    case MAY_PLANE:
        return store_word(text, PLANES, COUNT(PLANES), (uint32_t *)place);
    }
    return false;
}

/* Whether a field of this type, and all behind it, may be missing at the end of a sentence. */
/*@ assigns \nothing; */
static bool may_be_missing(enum type type) {
    return type == MAY_TEXT || type == MAY_PLANE || type == FROM_LENGTH;
}

/* Whether a field is empty that must not be; `more`: whether fields follow. */
/*@ assigns \nothing; */
static bool is_empty(stairscan_text_t text, enum type type, bool more) {
    bool full = type == FROM_LENGTH || type == LAST_LENGTH || (type == MAY_PLANE && !more);
    return full && text.length == 0;
}

/* Reads all fields of a table into `base`. Returns NULL, or the name of the wrong field. */
/*@ requires \valid(cursor);
    requires readable(cursor->left);
    requires \valid_read(fields + (0 .. count - 1));
    assigns *cursor, ((char *)base)[0 .. sizeof(stairscan_sentence_t) - 1];
    ensures readable(cursor->left); */
static const char *read_fields(struct cursor *cursor, const struct field *fields, size_t count,
                               void *base) {
    bool ended = false; /* this field of an older firmware's sentence is missing */
    size_t k;
    /*@ loop invariant 0 <= k <= count && readable(cursor->left);
        loop assigns k, ended, *cursor, ((char *)base)[0 .. sizeof(stairscan_sentence_t) - 1];
        loop unroll 16;
        loop variant count - k; */
    for (k = 0; k < count; k++) {
        stairscan_text_t text = {NULL, 0};
        ended = ended || (may_be_missing(fields[k].type) && !cursor->more);
        if (fields[k].type == REST) {
            if (!take_rest(cursor, &text)) {
                return fields[k].name;
            }
            cursor->more = false;
        } else if (!ended && (!take(cursor, &text) || has_framing(text))) {
            return fields[k].name;
        }
        if (!ended && is_empty(text, fields[k].type, cursor->more)) {
            return fields[k].name;
        }
        if (!store(text, fields[k].type, (unsigned char *)base + fields[k].at)) {
            return fields[k].name;
        }
    }
    return cursor->more ? "end" : NULL;
}

/*@ assigns \nothing;
    ensures \result.error == error && \result.field == field; */
static stairscan_result_t result(uint32_t error, const char *field) {
    stairscan_result_t result = {error, field};
    return result;
}

/* Finds the text between '$' and the last '*' and checks the CRC. */
/*@ requires length <= 0x7FFFFFFF;
    requires \valid_read(line + (0 .. length - 1));
    requires \valid(body);
    assigns *body;
    ensures \result == STAIRSCAN_FINE ==> readable(*body);
    ensures \result <= STAIRSCAN_BAD_CRC; */
static uint32_t unframe(const char *line, size_t length, stairscan_text_t *body) {
    stairscan_text_t sum;
    uint32_t crc = 0;
    size_t star;
    /*@ loop invariant 0 <= length <= \at(length, Pre);
        loop assigns length;
        loop variant length; */
    while (length > 0 && (line[length - 1] == '\r' || line[length - 1] == '\n')) {
        length--;
    }
    star = length;
    /*@ loop invariant 0 <= star <= length;
        loop assigns star;
        loop variant star; */
    while (star > 0 && line[star - 1] != '*') {
        star--;
    }
    if (length == 0 || line[0] != '$' || star == 0 || !are_printable(line, length)) {
        return STAIRSCAN_BAD_FRAME;
    }
    sum.at = line + star;
    sum.length = length - star;
    body->at = line + 1;
    body->length = star - 2;
    if (!read_hex(sum, &crc, 1) || crc != stairscan_crc32(body->at, body->length)) {
        return STAIRSCAN_BAD_CRC;
    }
    return STAIRSCAN_FINE;
}

stairscan_result_t stairscan_parse(const char *line, size_t length, stairscan_sentence_t *sentence) {
    struct cursor cursor = {{NULL, 0}, true};
    stairscan_text_t text = {NULL, 0};
    uint32_t error = unframe(line, length, &cursor.left);
    size_t form = 0;
    const char *wrong;
    if (error != STAIRSCAN_FINE) {
        return result(error, NULL);
    }
    if (!take(&cursor, &text) || !is_word(text, "PSTR")) {
        return result(STAIRSCAN_BAD_FRAME, NULL);
    }
    if (!take(&cursor, &text)) {
        return result(STAIRSCAN_BAD_FIELD, "name");
    }
    /*@ loop invariant 0 <= form <= COUNT(FORMS);
        loop assigns form;
        loop unroll 13;
        loop variant COUNT(FORMS) - form; */
    while (form < COUNT(FORMS) && !is_word(text, FORMS[form].name)) {
        form++;
    }
    if (form == COUNT(FORMS)) {
        return result(STAIRSCAN_BAD_FIELD, "name");
    }
    //@ split form;
    sentence->kind = FORMS[form].kind;
    wrong = read_fields(&cursor, FORMS[form].fields, FORMS[form].count, sentence);
    return result(wrong == NULL ? STAIRSCAN_FINE : STAIRSCAN_BAD_FIELD, wrong);
}

/* ---- writing ---- */

/* A line with room for what `finish` appends. */
/*@ predicate room(stairscan_line_t *line) = line->length <= STAIRSCAN_MAX_SENTENCE - TAIL; */

/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push(stairscan_line_t *line, char c) {
    if (line->length + TAIL < STAIRSCAN_MAX_SENTENCE) {
        line->bytes[line->length++] = c;
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires valid_read_string(word);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_word(stairscan_line_t *line, const char *word) {
    /*@ loop invariant room(line);
        loop invariant valid_read_string(word);
        loop assigns word, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 24; */
    while (*word != '\0') {
        push(line, *word++);
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires readable(text);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_text(stairscan_line_t *line, stairscan_text_t text, bool rest) {
    size_t k;
    /*@ loop invariant 0 <= k <= text.length && room(line);
        loop assigns k, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop variant text.length - k; */
    for (k = 0; k < text.length; k++) {
        char c = text.at[k];
        bool plain = is_printable(c) && (rest || (c != ',' && c != '*' && c != '$'));
        push(line, plain ? c : ' ');
    }
}

/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_digits(stairscan_line_t *line, uint32_t value) {
    char reversed[10];
    size_t count = 0;
    /*@ loop invariant 0 <= count <= 9 && 0 <= value;
        loop invariant count == 1 ==> value <= 429496729;
        loop invariant count == 2 ==> value <= 42949672;
        loop invariant count == 3 ==> value <= 4294967;
        loop invariant count == 4 ==> value <= 429496;
        loop invariant count == 5 ==> value <= 42949;
        loop invariant count == 6 ==> value <= 4294;
        loop invariant count == 7 ==> value <= 429;
        loop invariant count == 8 ==> value <= 42;
        loop invariant count == 9 ==> value <= 4;
        loop assigns count, value, reversed[0 .. 9];
        loop unroll 10;
        loop variant value; */
    do {
        reversed[count++] = (char)('0' + (char)(value % 10));
        value /= 10;
    } while (value > 0);
    /*@ loop invariant 0 <= count <= 10 && room(line);
        loop assigns count, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 10;
        loop variant count; */
    while (count > 0) {
        push(line, reversed[--count]);
    }
}

/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static uint32_t push_sign(stairscan_line_t *line, int32_t value) {
    if (value < 0) {
        push(line, '-');
    }
    return value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
}

/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_length(stairscan_line_t *line, int32_t tenths) {
    uint32_t magnitude = push_sign(line, tenths);
    push_digits(line, magnitude / 10);
    push(line, '.');
    push_digits(line, magnitude % 10);
}

/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_reasons(stairscan_line_t *line, uint64_t reasons) {
    bool first = true;
    uint32_t k;
    /*@ loop invariant 0 <= k <= COUNT(REASONS) && room(line);
        loop assigns k, first, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 64;
        loop variant COUNT(REASONS) - k; */
    for (k = 0; k < COUNT(REASONS); k++) {
        if ((reasons >> k & 1) != 0) {
            /* The fields that follow must fit, too: the rarest reasons are last. */
            size_t length = line->length + 1 + stairscan_text(REASONS[k]).length;
            if (length + AFTER_REASONS + TAIL > STAIRSCAN_MAX_SENTENCE) {
                return;
            }
            if (!first) {
                push(line, '+');
            }
            first = false;
            push_word(line, REASONS[k]);
        }
    }
}

/* Appends eight hex digits; the caller ensures the space. */
/*@ requires \valid(line);
    requires line->length <= STAIRSCAN_MAX_SENTENCE - 8;
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures line->length == \old(line->length) + 8; */
static void put_hex(stairscan_line_t *line, uint32_t word) {
    static const char DIGITS[] = "0123456789ABCDEF";
    int shift;
    /*@ loop invariant -4 <= shift <= 28 && shift % 4 == 0;
        loop invariant line->length == \at(line->length, Pre) + (28 - shift) / 4;
        loop assigns shift, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 8;
        loop variant shift + 4; */
    for (shift = 28; shift >= 0; shift -= 4) {
        line->bytes[line->length++] = DIGITS[word >> shift & 15u];
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires count <= 3;
    requires \valid_read(words + (0 .. count - 1));
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_hex(stairscan_line_t *line, const uint32_t *words, size_t count) {
    size_t k;
    /*@ loop invariant 0 <= k <= count && room(line);
        loop assigns k, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 3;
        loop variant count - k; */
    for (k = 0; k < count; k++) {
        if (line->length + 8 + TAIL <= STAIRSCAN_MAX_SENTENCE) {
            put_hex(line, words[k]);
        }
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires \valid_read(value);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_optional(stairscan_line_t *line, enum type type, const stairscan_optional_t *value) {
    if (value->present && type == PITCH) {
        push_digits(line, push_sign(line, value->value));
    } else if (value->present) {
        push_length(line, value->value);
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires \valid_read(time);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_time(stairscan_line_t *line, const stairscan_time_t *time) {
    if (time->present) {
        push_digits(line, time->ms);
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires \valid_read(word);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_optional_hash(stairscan_line_t *line, const stairscan_word_t *word) {
    if (word->present) {
        push_hex(line, &word->word, 1);
    }
}

/* Writes the value of a member that `store` has set. */
/*@ requires \valid(line);
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_field(stairscan_line_t *line, enum type type, const void *place) {
    const uint32_t *number = (const uint32_t *)place; /* of most types; not dereferenced for the others */
    push(line, ',');
    switch (type) {
    case TEXT:
    case MAY_TEXT:
    case REST:
        push_text(line, *(const stairscan_text_t *)place, type == REST);
        return;
    case U8:
    case U16:
    case U32:
        push_digits(line, *number);
        return;
    case TIME:
        push_time(line, (const stairscan_time_t *)place);
        return;
    case HASH:
        push_hex(line, number, 1);
        return;
    case MAY_HASH:
        push_optional_hash(line, (const stairscan_word_t *)place);
        return;
    case SERIAL:
        push_hex(line, number, 3);
        return;
    case LENGTH:
        push_length(line, *(const int32_t *)place);
        return;
    case MAY_LENGTH:
    case FROM_LENGTH:
    case LAST_LENGTH:
    case MAY_PERCENT:
    case PITCH:
        push_optional(line, type, (const stairscan_optional_t *)place);
        return;
    case PERCENT:
        push_length(line, (int32_t)(*number <= 1000 ? *number : 1000));
        return;
    case STATUS:
        push_word(line, word_at(STATUSES, COUNT(STATUSES), *number));
        return;
    case DIRECTION:
        push_word(line, word_at(DIRECTIONS, COUNT(DIRECTIONS), *number));
        return;
    case ENDING:
        push_word(line, word_at(ENDINGS, COUNT(ENDINGS), *number));
        return;
    case REASON:
        push_word(line, stairscan_reason_word(*number));
        return;
    case REASON_SET:
        push_reasons(line, *(const uint64_t *)place);
        return;
    case MAY_PLANE:
        push_word(line, word_at(PLANES, COUNT(PLANES), *number));
        return;
    }
}

/*@ requires \valid(line);
    requires valid_read_string(prefix);
    requires valid_read_string(name);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void begin(stairscan_line_t *line, const char *prefix, const char *name) {
    line->length = 0;
    push_word(line, prefix);
    push_word(line, name);
}

/* Whether a sentence ends before this field, `place`: it and those behind it have no value. Behind a plane comes the
 * slope. */
/*@ requires \valid_read(field);
    assigns \nothing; */
static bool ends_at(const struct field *field, const unsigned char *place, const void *base) {
    const stairscan_optional_t *from = NULL;
    switch (field->type) {
    case MAY_PLANE:
        if (*(const uint32_t *)(const void *)place != STAIRSCAN_PLANE_AS_SET) {
            return false;
        }
        from = (const stairscan_optional_t *)(const void *)((const unsigned char *)base + field[1].at);
        return !from->present;
    case FROM_LENGTH:
        from = (const stairscan_optional_t *)(const void *)place;
        return !from->present;
    default:
        return false;
    }
}

/*@ requires \valid(line);
    requires room(line);
    requires \valid_read(fields + (0 .. count - 1));
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
    ensures room(line); */
static void push_fields(stairscan_line_t *line, const struct field *fields, size_t count,
                        const void *base) {
    size_t k;
    /*@ loop invariant 0 <= k <= count && room(line);
        loop assigns k, line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE - 1];
        loop unroll 16;
        loop variant count - k; */
    for (k = 0; k < count; k++) {
        const unsigned char *place = (const unsigned char *)base + fields[k].at;
        if (ends_at(fields + k, place, base)) {
            return;
        }
        push_field(line, fields[k].type, place);
    }
}

/* Appends CRC and CR LF, for which the pushed fields leave space. */
/*@ requires \valid(line);
    requires 1 <= line->length;
    requires room(line);
    assigns line->length, line->bytes[0 .. STAIRSCAN_MAX_SENTENCE];
    ensures line->length == \old(line->length) + TAIL && line->bytes[line->length] == 0; */
static void finish(stairscan_line_t *line) {
    uint32_t crc = stairscan_crc32(line->bytes + 1, line->length - 1);
    line->bytes[line->length++] = '*';
    put_hex(line, crc);
    line->bytes[line->length++] = '\r';
    line->bytes[line->length++] = '\n';
    line->bytes[line->length] = '\0';
}

void stairscan_write(const stairscan_sentence_t *sentence, stairscan_line_t *line) {
    line->length = 0;
    line->bytes[0] = '\0';
    if (sentence->kind < COUNT(FORMS)) {
        const struct form *form = &FORMS[sentence->kind];
        begin(line, "$PSTR,", form->name);
        push_fields(line, form->fields, form->count, sentence);
        finish(line);
    }
}

/* ---- commands ---- */

/* Whether a command has the argument on or off. */
/*@ assigns \nothing; */
static bool is_switch(uint32_t command) {
    return command == STAIRSCAN_COMMAND_GUARD || command == STAIRSCAN_COMMAND_WATCH;
}

void stairscan_write_command(const stairscan_command_t *command, stairscan_line_t *line) {
    bool has_key = command->kind == STAIRSCAN_COMMAND_SET ||
                   (command->kind == STAIRSCAN_COMMAND_GET && command->key.length > 0);
    begin(line, "$PSTC,", word_at(COMMANDS, COUNT(COMMANDS), command->kind));
    if (has_key) {
        push_field(line, TEXT, &command->key);
    }
    if (command->kind == STAIRSCAN_COMMAND_SET) {
        push_field(line, TEXT, &command->value);
    }
    if (is_switch(command->kind)) {
        push_field(line, TEXT, &command->value);
    }
    if (command->kind == STAIRSCAN_COMMAND_MOTION) {
        push_fields(line, MOTION, COUNT(MOTION), &command->motion);
    }
    if (command->kind == STAIRSCAN_COMMAND_CALIBRATE) {
        push_fields(line, CALIBRATION, COUNT(CALIBRATION), &command->calibration);
    }
    finish(line);
}

/*@ assigns \nothing; */
static stairscan_refusal_t refusal(const char *command, const char *field) {
    stairscan_refusal_t refusal = {command, field};
    return refusal;
}

/*@ requires readable(text);
    requires valid_read_string(prefix);
    assigns \nothing;
    ensures \result ==> text.length >= strlen(prefix); */
static bool begins_with(stairscan_text_t text, const char *prefix) {
    stairscan_text_t head = stairscan_text(prefix);
    if (text.length < head.length) {
        return false;
    }
    text.length = head.length;
    return is_word(text, prefix);
}

/* Removes the frame if there is one. Returns NULL, or the error. */
/*@ requires \valid(text);
    requires readable(*text);
    assigns *text;
    ensures readable(*text); */
static const char *unframe_command(stairscan_text_t *text) {
    static const char PREFIX[] = "PSTC,";
    stairscan_text_t sum;
    uint32_t crc = 0;
    if (!strip(text, '$')) {
        return NULL;
    }
    if (text->length < 9 || text->at[text->length - 9] != '*') {
        return "crc";
    }
    text->length -= 9;
    sum.at = text->at + text->length + 1;
    sum.length = 8;
    if (!read_hex(sum, &crc, 1) || crc != stairscan_crc32(text->at, text->length)) {
        return "crc";
    }
    //@ assert strlen(&PREFIX[0]) == 5;
    if (has_framing(*text) || !begins_with(*text, PREFIX)) {
        return "frame";
    }
    text->at += 5;
    text->length -= 5;
    return NULL;
}

/*@ requires readable(body);
    requires \valid(command);
    assigns *command; */
static stairscan_refusal_t parse_motion(stairscan_text_t body, stairscan_command_t *command) {
    struct cursor cursor;
    stairscan_text_t name = {NULL, 0};
    const char *wrong;
    cursor.left = body;
    cursor.more = true;
    command->kind = STAIRSCAN_COMMAND_MOTION;
    if (!take(&cursor, &name) || !is_word(name, "MOTION")) {
        return refusal("MOTION", "name");
    }
    wrong = read_fields(&cursor, MOTION, COUNT(MOTION), &command->motion);
    return refusal(wrong == NULL ? NULL : "MOTION", wrong);
}

/* Returns the next word, separated by commas and spaces; empty if there is none. */
/*@ requires \valid(left);
    requires readable(*left);
    assigns *left;
    ensures readable(*left) && readable(\result); */
static stairscan_text_t next_word(stairscan_text_t *left) {
    stairscan_text_t word;
    /*@ loop invariant readable(*left);
        loop assigns *left;
        loop variant left->length; */
    while (strip(left, ',') || strip(left, ' ')) {
    }
    word.at = left->at;
    word.length = 0;
    /*@ loop invariant readable(*left) && word.length + left->length <= 0x7FFFFFFF;
        loop invariant \valid_read(word.at + (0 .. word.length + left->length - 1));
        loop invariant left->at == word.at + word.length;
        loop assigns *left, word.length;
        loop variant left->length; */
    while (left->length > 0 && left->at[0] != ',' && left->at[0] != ' ') {
        left->at++;
        left->length--;
        word.length++;
    }
    return word;
}

/* Reads key and value of `get` and `set`. Returns NULL, or the wrong field. */
/*@ requires \valid(left);
    requires readable(*left);
    requires \valid(command);
    requires \separated(left, command);
    assigns *left, command->key, command->value;
    ensures readable(*left); */
static const char *parse_setting(stairscan_text_t *left, stairscan_command_t *command) {
    bool get = command->kind == STAIRSCAN_COMMAND_GET;
    uint32_t key;
    command->key = next_word(left);
    key = find(command->key, KEYS, COUNT(KEYS));
    if (get) {
        bool known = command->key.length == 0 || key < COUNT(KEYS) ||
                     find(command->key, MEASURES, COUNT(MEASURES)) < COUNT(MEASURES);
        return known ? NULL : "key";
    }
    if (key == COUNT(KEYS)) {
        return "key";
    }
    command->value = next_word(left);
    return command->value.length > 0 ? NULL : KEYS[key];
}

/* Whether a number is a date: year, month and day. */
/*@ assigns \nothing; */
static bool is_date(uint32_t date) {
    uint32_t month = date / 100 % 100;
    uint32_t day = date % 100;
    return date >= 20000000 && date < 100000000 && month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

/* Reads the arguments of `calibrate`. Returns NULL, or the wrong field. */
/*@ requires \valid(left);
    requires readable(*left);
    requires \valid(calibration);
    requires \separated(left, calibration);
    assigns *left, *calibration;
    ensures readable(*left); */
static const char *parse_calibration(stairscan_text_t *left, stairscan_calibration_t *calibration) {
    if (!read_count(next_word(left), 65535, &calibration->wall_mm)) {
        return "wall";
    }
    if (!read_count(next_word(left), UINT32_MAX, &calibration->date) || !is_date(calibration->date)) {
        return "date";
    }
    return NULL;
}

/* Reads the argument of `guard` and `watch`. Returns NULL, or the wrong field. */
/*@ requires \valid(left);
    requires readable(*left);
    requires \valid(value);
    requires \separated(left, value);
    assigns *left, *value;
    ensures readable(*left); */
static const char *parse_switch(stairscan_text_t *left, stairscan_text_t *value) {
    *value = next_word(left);
    return is_word(*value, "on") || is_word(*value, "off") ? NULL : "switch";
}

stairscan_refusal_t stairscan_parse_command(const char *line, size_t length,
                                            stairscan_command_t *command) {
    static const stairscan_command_t none = {0, {NULL, 0}, {NULL, 0}, {0, 0, {false, 0}}, {0, 0}};
    stairscan_text_t whole = {line, length};
    stairscan_text_t left = whole;
    const char *wrong;
    *command = none;
    if (length > STAIRSCAN_MAX_COMMAND || !are_printable(line, length)) {
        return refusal("-", "line");
    }
    wrong = unframe_command(&left);
    if (wrong != NULL) {
        return refusal("-", wrong);
    }
    if (begins_with(whole, "$PSTC,MOTION")) {
        return parse_motion(left, command);
    }
    command->kind = find(next_word(&left), COMMANDS, STAIRSCAN_COMMAND_MOTION);
    if (command->kind == STAIRSCAN_COMMAND_MOTION) {
        return refusal("-", "command");
    }
    if (command->kind == STAIRSCAN_COMMAND_GET || command->kind == STAIRSCAN_COMMAND_SET) {
        wrong = parse_setting(&left, command);
    }
    if (is_switch(command->kind)) {
        wrong = parse_switch(&left, &command->value);
    }
    if (command->kind == STAIRSCAN_COMMAND_CALIBRATE) {
        wrong = parse_calibration(&left, &command->calibration);
    }
    if (wrong == NULL && next_word(&left).length > 0) {
        wrong = "arguments";
    }
    return refusal(wrong == NULL ? NULL : COMMANDS[command->kind], wrong);
}

/* ---- answers ---- */

stairscan_rules_t stairscan_default_rules(void) {
    stairscan_rules_t rules = {500, 17000, 5000, 600, false, 0, 400};
    return rules;
}

void stairscan_init(stairscan_t *scanner, const stairscan_rules_t *rules) {
    scanner->rules = *rules;
    scanner->has_answer = scanner->collecting = scanner->heard = false;
    scanner->faulty = scanner->doubtful = scanner->aged = scanner->skipping = false;
    scanner->edge_known = false;
    scanner->has_sweep = scanner->sweep_aged = scanner->sweep_faulty = false;
    scanner->made_with.present = false;
    scanner->made_with.word = 0;
    scanner->damaged = scanner->dropped = 0;
    scanner->got_steps = scanner->got_drops = scanner->got_maybes = scanner->last_scan = 0;
    scanner->heard_ms = scanner->uptime_ms = 0;
    scanner->length = 0;
}

/*@ requires \valid(counter);
    assigns *counter; */
static void count(uint32_t *counter) {
    if (*counter < UINT32_MAX) {
        ++*counter;
    }
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->dropped, scanner->collecting;
    ensures stairscan_sound(scanner); */
static void drop(stairscan_t *scanner) {
    if (scanner->collecting) {
        count(&scanner->dropped);
    }
    scanner->collecting = false;
}

/* Voids all earlier information. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->dropped, scanner->collecting, scanner->has_answer, scanner->faulty, scanner->doubtful,
        scanner->aged, scanner->edge_known;
    ensures stairscan_sound(scanner); */
static void forget(stairscan_t *scanner) {
    drop(scanner);
    scanner->has_answer = scanner->faulty = scanner->doubtful = scanner->aged = false;
    scanner->edge_known = false;
}

/* Voids the guard sweep. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->has_sweep, scanner->sweep_aged, scanner->sweep_faulty;
    ensures stairscan_sound(scanner); */
static void forget_sweep(stairscan_t *scanner) {
    scanner->has_sweep = scanner->sweep_aged = scanner->sweep_faulty = false;
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->dropped, scanner->collecting, scanner->has_answer, scanner->faulty, scanner->doubtful,
        scanner->aged, scanner->edge_known, scanner->last_scan, scanner->uptime_ms, scanner->has_sweep,
        scanner->sweep_aged, scanner->sweep_faulty, scanner->made_with;
    ensures stairscan_sound(scanner); */
static void restarted(stairscan_t *scanner) {
    forget(scanner);
    forget_sweep(scanner);
    scanner->made_with.present = false;
    scanner->last_scan = scanner->uptime_ms = 0;
}

/* Keeps the hash of the settings, which GUARD does not contain. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->made_with;
    ensures stairscan_sound(scanner); */
static void keep_hash(stairscan_t *scanner, uint32_t settings) {
    scanner->made_with.present = true;
    scanner->made_with.word = settings;
}

/* Returns the time since the last row of the sweep, rounded up. */
/*@ requires \valid_read(scanner);
    assigns \nothing; */
static uint32_t sweep_age(const stairscan_t *scanner, uint32_t now_ms) {
    uint32_t since = now_ms - scanner->sweep.came_ms;
    return since < UINT32_MAX - STAIRSCAN_SWEEP_DELAY_MS ? since + STAIRSCAN_SWEEP_DELAY_MS : UINT32_MAX;
}

/* Checks the timeouts: silence voids everything, age the answer and the sweep. All remain when the clock wraps. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->dropped, scanner->collecting, scanner->has_answer, scanner->faulty, scanner->doubtful,
        scanner->aged, scanner->edge_known, scanner->heard, scanner->has_sweep, scanner->sweep_aged,
        scanner->sweep_faulty;
    ensures stairscan_sound(scanner); */
static void pass(stairscan_t *scanner, uint32_t now_ms) {
    if (scanner->heard && now_ms - scanner->heard_ms > scanner->rules.silence_ms) {
        scanner->heard = false;
        forget(scanner);
        forget_sweep(scanner);
    }
    if (scanner->has_answer && now_ms - scanner->answer.came_ms > scanner->rules.oldest_ms) {
        scanner->aged = true;
    }
    if (scanner->has_sweep && sweep_age(scanner, now_ms) > scanner->rules.oldest_sweep_ms) {
        scanner->sweep_aged = true;
    }
}

/* Returns the nearest possible place of a drop's edge. */
/*@ requires \valid_read(edge);
    assigns \nothing;
    ensures -0x200000000 <= \result <= 0x200000000; */
static int64_t brink(const stairscan_drop_t *edge) {
    return edge->distance - 3 * (int64_t)edge->distance_sigma;
}

/* Keeps the drop of an answer of the depth plane: a following answer of the height plane does not cancel it. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->edge_known, scanner->edge;
    ensures stairscan_sound(scanner); */
static void keep_edge(stairscan_t *scanner) {
    const stairscan_answer_t *coming = &scanner->coming;
    if (coming->head.plane != STAIRSCAN_PLANE_HEIGHT) {
        scanner->edge_known = coming->head.drops > 0;
        scanner->edge = scanner->edge_known ? brink(&coming->drop) + coming->travel : 0;
    }
}

/* Makes the received answer the current one if it is complete. Returns whether it is. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool complete(stairscan_t *scanner) {
    const stairscan_scan_t *head = &scanner->coming.head;
    if (scanner->got_steps < head->steps || scanner->got_drops < head->drops ||
        scanner->got_maybes < head->maybes) {
        return false;
    }
    keep_edge(scanner);
    scanner->answer = scanner->coming;
    scanner->has_answer = true;
    scanner->collecting = scanner->aged = scanner->doubtful = scanner->faulty = false;
    return true;
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool take_head(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    const stairscan_scan_t *head = &scanner->sentence.as.scan;
    drop(scanner);
    keep_hash(scanner, head->settings);
    if (head->status != STAIRSCAN_OK) {
        scanner->has_answer = false;
        scanner->faulty = head->status == STAIRSCAN_FAULT;
        scanner->doubtful = head->status == STAIRSCAN_DEGRADED;
    }
    if (head->scan > 0) {
        scanner->last_scan = head->scan;
    }
    scanner->collecting = true;
    scanner->edge_known = scanner->edge_known && head->plane == STAIRSCAN_PLANE_HEIGHT;
    scanner->got_steps = scanner->got_drops = scanner->got_maybes = 0;
    scanner->coming.head = *head;
    scanner->coming.came_ms = now_ms;
    scanner->coming.travel = travel;
    if (head->plane == STAIRSCAN_PLANE_HEIGHT && !scanner->edge_known) {
        drop(scanner); /* the answer with the drop was lost */
        return false;
    }
    if (head->steps > STAIRSCAN_MAX_STEPS || head->drops > 1 || head->maybes > STAIRSCAN_MAX_MAYBES ||
        (head->status == STAIRSCAN_FAULT && (head->steps > 0 || head->drops > 0 || head->maybes > 0))) {
        drop(scanner);
        return false;
    }
    return complete(scanner);
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool take_step(stairscan_t *scanner) {
    const stairscan_step_t *step = &scanner->sentence.as.step;
    const stairscan_scan_t *head = &scanner->coming.head;
    uint32_t got = scanner->got_steps;
    if (!scanner->collecting || step->scan != head->scan || step->count != head->steps ||
        step->index != got + 1 || got >= head->steps || got >= STAIRSCAN_MAX_STEPS) {
        drop(scanner);
        return false;
    }
    scanner->coming.steps[got] = *step;
    scanner->got_steps = got + 1;
    return complete(scanner);
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool take_drop(stairscan_t *scanner) {
    const stairscan_drop_t *told = &scanner->sentence.as.drop;
    const stairscan_scan_t *head = &scanner->coming.head;
    if (!scanner->collecting || scanner->got_steps < head->steps || told->scan != head->scan ||
        scanner->got_drops >= head->drops) {
        drop(scanner);
        return false;
    }
    scanner->coming.drop = *told;
    scanner->got_drops = 1;
    return complete(scanner);
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool take_maybe(stairscan_t *scanner) {
    const stairscan_maybe_t *maybe = &scanner->sentence.as.maybe;
    const stairscan_scan_t *head = &scanner->coming.head;
    uint32_t got = scanner->got_maybes;
    if (!scanner->collecting || scanner->got_steps < head->steps ||
        scanner->got_drops < head->drops || maybe->scan != head->scan || maybe->count != head->maybes || maybe->index != got + 1 || got >= head->maybes ||
        got >= STAIRSCAN_MAX_MAYBES) {
        drop(scanner);
        return false;
    }
    scanner->coming.maybes[got] = *maybe;
    scanner->got_maybes = got + 1;
    return complete(scanner);
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns scanner->has_sweep, scanner->sweep, scanner->sweep_aged, scanner->sweep_faulty;
    ensures stairscan_sound(scanner); */
static void take_guard(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    const stairscan_guard_t *guard = &scanner->sentence.as.guard;
    if (scanner->has_sweep && guard->sweep == scanner->sweep.guard.sweep && guard->status == STAIRSCAN_OK) {
        return; /* the same sweep again, such as from a buffer */
    }
    forget_sweep(scanner);
    scanner->has_sweep = true;
    scanner->sweep.guard = *guard;
    scanner->sweep.came_ms = now_ms;
    scanner->sweep.travel = travel;
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static void take_live(stairscan_t *scanner) {
    const stairscan_live_t *live = &scanner->sentence.as.live;
    if (live->uptime_ms < scanner->uptime_ms) {
        restarted(scanner); /* its BOOT was lost */
    }
    scanner->uptime_ms = live->uptime_ms;
    if (live->scan > scanner->last_scan && live->scan - scanner->last_scan > 1) {
        forget(scanner); /* the SCAN of one in between was lost, with an unknown status */
    }
    if (is_word(live->state, "fault")) {
        forget(scanner);
        forget_sweep(scanner);
        scanner->faulty = scanner->sweep_faulty = true;
    }
}

/* Processes the received sentence. Returns whether it completes an answer. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static bool act(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    switch (scanner->sentence.kind) {
    case STAIRSCAN_SCAN:
        return take_head(scanner, now_ms, travel);
    case STAIRSCAN_STEP:
        return take_step(scanner);
    case STAIRSCAN_DROP:
        return take_drop(scanner);
    case STAIRSCAN_MAYBE:
        return take_maybe(scanner);
    case STAIRSCAN_GUARD:
        take_guard(scanner, now_ms, travel);
        return false;
    case STAIRSCAN_LIVE:
        take_live(scanner);
        return false;
    case STAIRSCAN_STAT:
        keep_hash(scanner, scanner->sentence.as.stat.settings);
        return false;
    case STAIRSCAN_HALT:
        restarted(scanner);
        scanner->faulty = scanner->sweep_faulty = true;
        return false;
    case STAIRSCAN_BOOT:
        restarted(scanner);
        keep_hash(scanner, scanner->sentence.as.boot.settings);
        return false;
    default:
        return false;
    }
}

/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
static enum stairscan_event end_line(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    size_t length = scanner->length;
    bool skipped = scanner->skipping;
    scanner->length = 0;
    scanner->skipping = false;
    if (!skipped && length == 0) {
        return STAIRSCAN_NOTHING;
    }
    if (skipped || stairscan_parse(scanner->line, length, &scanner->sentence).error != STAIRSCAN_FINE) {
        count(&scanner->damaged);
        return STAIRSCAN_DAMAGED;
    }
    scanner->heard = true;
    scanner->heard_ms = now_ms;
    return act(scanner, now_ms, travel) ? STAIRSCAN_ANSWER : STAIRSCAN_SENTENCE;
}

/* Whether a '$' continues the line: FAIL offers a command's whole sentence, after a space. Any other '$' begins
 * a new line, so that noise or a lost line end does not cost the following line. */
/*@ requires \valid_read(scanner);
    requires 0 < scanner->length <= STAIRSCAN_MAX_SENTENCE;
    assigns \nothing; */
static bool is_within(const stairscan_t *scanner) {
    return !scanner->skipping && scanner->line[0] == '$' && scanner->line[scanner->length - 1] == ' ';
}

enum stairscan_event stairscan_take(stairscan_t *scanner, char byte, uint32_t now_ms, int32_t travel) {
    enum stairscan_event event = STAIRSCAN_NOTHING;
    pass(scanner, now_ms);
    if (byte == '\r' || byte == '\n') {
        return end_line(scanner, now_ms, travel);
    }
    if (byte == '$' && scanner->length > 0 && !is_within(scanner)) {
        count(&scanner->damaged);
        event = STAIRSCAN_DAMAGED;
        scanner->skipping = false;
        scanner->length = 0;
    }
    if (scanner->length >= sizeof scanner->line) {
        scanner->skipping = true;
    }
    if (!scanner->skipping) {
        scanner->line[scanner->length++] = byte;
    }
    return event;
}

/*@ assigns \nothing;
    ensures 0 <= \result;
    ensures value <= 0 ==> \result == 0;
    ensures 0 <= value <= INT32_MAX ==> \result == value;
    ensures INT32_MAX <= value ==> \result == INT32_MAX; */
static int32_t clamp(int64_t value) {
    if (value < 0) {
        return 0;
    }
    return value > INT32_MAX ? INT32_MAX : (int32_t)value;
}

/* Distance error that the margin covers, 0.1 mm. */
#define WITHIN_MARGIN 300

/* Returns the part of a step's expanded uncertainty (3 sigma) that the margin does not cover, 0.1 mm. */
/*@ requires \valid_read(step);
    assigns \nothing;
    ensures 0 <= \result <= 0x200000000; */
static int64_t nearer(const stairscan_step_t *step) {
    int64_t beyond = 3 * (int64_t)step->distance_sigma - WITHIN_MARGIN;
    return beyond > 0 ? beyond : 0;
}

stairscan_optional_t stairscan_free(const stairscan_answer_t *answer) {
    stairscan_optional_t way = {false, 0};
    int64_t end = answer->head.horizon.value;
    if (answer->head.status != STAIRSCAN_OK || !answer->head.horizon.present) {
        return way;
    }
    if (answer->head.steps > 0 && answer->steps[0].distance < end) {
        end = answer->steps[0].distance;
    }
    if (answer->head.drops > 0 && brink(&answer->drop) < end) {
        end = brink(&answer->drop);
    }
    way.present = true;
    way.value = clamp(end);
    return way;
}

/* Returns the remaining valid distance of the answer from the chair's current position, and its level part,
 * which ends at `edge` at the latest. */
/*@ requires \valid_read(answer);
    requires -0x200000000 <= gone <= 0x200000000;
    requires -0x1000000000 <= edge;
    assigns \nothing; */
static stairscan_permit_t go(const stairscan_answer_t *answer, int64_t gone, int64_t edge) {
    stairscan_permit_t permit = {STAIRSCAN_GO, STAIRSCAN_WHY_OK, 0, 0};
    int64_t vouched = answer->head.horizon.value - gone;
    int64_t clear = edge < vouched ? edge : vouched;
    if (answer->head.steps > 0) {
        int64_t step = answer->steps[0].distance - nearer(&answer->steps[0]) - gone;
        clear = step < clear ? step : clear;
    }
    if (answer->head.drops > 0 && brink(&answer->drop) - gone < clear) {
        clear = brink(&answer->drop) - gone;
    }
    if (answer->head.maybes > 0 && answer->maybes[0].distance - gone < clear) {
        clear = answer->maybes[0].distance - gone;
    }
    permit.vouched = clamp(vouched);
    permit.clear = clamp(clear);
    if (permit.vouched == 0) {
        permit.action = STAIRSCAN_STOP;
        permit.why = STAIRSCAN_WHY_FAR;
    }
    return permit;
}

/*@ assigns \nothing;
    ensures \result.action == action && \result.why == why && \result.vouched == 0 && \result.clear == 0; */
static stairscan_permit_t no_go(enum stairscan_action action, enum stairscan_why why) {
    stairscan_permit_t permit = {0, 0, 0, 0};
    permit.action = action;
    permit.why = why;
    return permit;
}

stairscan_permit_t stairscan_may(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    const stairscan_answer_t *answer = &scanner->answer;
    const stairscan_rules_t *rules = &scanner->rules;
    int64_t edge = INT64_MAX;
    int64_t gone;
    pass(scanner, now_ms);
    if (!scanner->heard) {
        return no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_SILENCE);
    }
    if (scanner->faulty || (scanner->has_answer && answer->head.status == STAIRSCAN_FAULT)) {
        return no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT);
    }
    if (!scanner->has_answer) {
        return scanner->doubtful ? no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_DEGRADED)
                                 : no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER);
    }
    gone = (int64_t)travel - answer->travel;
    if (rules->check_settings && answer->head.settings != rules->settings) {
        return no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_SETTINGS);
    }
    if (scanner->aged) {
        return no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_OLD);
    }
    if (gone > rules->farthest || -gone > rules->farthest) {
        return no_go(STAIRSCAN_STOP, STAIRSCAN_WHY_FAR);
    }
    if (answer->head.status != STAIRSCAN_OK) {
        return no_go(STAIRSCAN_HINT, STAIRSCAN_WHY_DEGRADED);
    }
    if (!answer->head.horizon.present) {
        return no_go(STAIRSCAN_HINT, STAIRSCAN_WHY_NO_HORIZON);
    }
    if (scanner->edge_known) {
        edge = scanner->edge - travel - rules->margin;
    }
    return go(answer, gone + rules->margin, edge);
}

/*@ requires \valid_read(scanner);
    assigns \nothing;
    ensures \result <= STAIRSCAN_WHY_FAR; */
static uint32_t why_no_sweep(const stairscan_t *scanner, int32_t travel) {
    const stairscan_rules_t *rules = &scanner->rules;
    const stairscan_word_t *made_with = &scanner->made_with;
    int64_t gone = (int64_t)travel - scanner->sweep.travel;
    if (!scanner->heard) {
        return STAIRSCAN_WHY_SILENCE;
    }
    if (scanner->sweep_faulty || (scanner->has_sweep && scanner->sweep.guard.status == STAIRSCAN_FAULT)) {
        return STAIRSCAN_WHY_FAULT;
    }
    if (!scanner->has_sweep) {
        return STAIRSCAN_WHY_NO_ANSWER;
    }
    if (rules->check_settings && (!made_with->present || made_with->word != rules->settings)) {
        return STAIRSCAN_WHY_SETTINGS;
    }
    if (scanner->sweep_aged) {
        return STAIRSCAN_WHY_OLD;
    }
    if (gone > rules->farthest || -gone > rules->farthest) {
        return STAIRSCAN_WHY_FAR;
    }
    if (scanner->sweep.guard.status != STAIRSCAN_OK) {
        return STAIRSCAN_WHY_DEGRADED;
    }
    return scanner->sweep.guard.free.present ? STAIRSCAN_WHY_OK : STAIRSCAN_WHY_NO_HORIZON;
}

stairscan_guard_permit_t stairscan_guard_may(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    stairscan_guard_permit_t permit = {STAIRSCAN_STOP, STAIRSCAN_WHY_OK, STAIRSCAN_ENDS_UNKNOWN, 0, UINT32_MAX};
    const stairscan_sweep_t *sweep = &scanner->sweep;
    pass(scanner, now_ms);
    permit.why = why_no_sweep(scanner, travel);
    if (scanner->has_sweep) {
        permit.ending = sweep->guard.ending;
        permit.age_ms = scanner->sweep_aged ? UINT32_MAX : sweep_age(scanner, now_ms);
    }
    if (permit.why == STAIRSCAN_WHY_OK) {
        int64_t gone = (int64_t)travel - sweep->travel;
        permit.clear = clamp(sweep->guard.free.value - gone - scanner->rules.margin);
        permit.action = permit.clear > 0 ? STAIRSCAN_GO : STAIRSCAN_STOP;
        permit.why = permit.clear > 0 ? STAIRSCAN_WHY_OK : STAIRSCAN_WHY_NEAR;
    }
    return permit;
}

/* ---- speed limit ---- */

uint32_t stairscan_guard_free_mm(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    return (uint32_t)stairscan_guard_may(scanner, now_ms, travel).clear / 10;
}

uint32_t stairscan_free_mm(stairscan_t *scanner, uint32_t now_ms, int32_t travel) {
    stairscan_permit_t permit = stairscan_may(scanner, now_ms, travel);
    return permit.action == STAIRSCAN_GO ? (uint32_t)permit.clear / 10 : 0;
}

/* A 96-bit integer, high * 2^32 + low. C99 has none, and a 64-bit division would call a library function. */
struct wide {
    uint64_t high;
    uint32_t low;
};

/*@ assigns \nothing; */
static struct wide product(uint64_t a, uint32_t b) {
    uint64_t low = (a & UINT32_MAX) * b;
    struct wide product;
    product.high = (a >> 32) * b + (low >> 32); /* at most (2^32 - 1) * 2^32 */
    product.low = (uint32_t)(low & UINT32_MAX);
    return product;
}

/*@ assigns \nothing; */
static bool is_at_most(struct wide a, struct wide b) {
    return a.high != b.high ? a.high < b.high : a.low <= b.low;
}

/* Whether the chair stops within `free_um` of ground. Products of mm/s and ms are micrometres: v * v / (2 * a)
 * mm are 500 * v * v / a micrometres, and nothing is rounded. */
/*@ requires \valid_read(chair);
    assigns \nothing; */
static bool stops(uint32_t speed, uint64_t free_um, uint32_t fastest, const stairscan_chair_t *chair) {
    uint64_t reaction_um = (uint64_t)(speed > fastest ? speed : fastest) * chair->latency_ms;
    return reaction_um <= free_um && is_at_most(product((uint64_t)speed * speed, 500),
                                                product(free_um - reaction_um, chair->deceleration_mm_s2));
}

uint32_t stairscan_max_speed(const stairscan_ground_t *ground, const stairscan_chair_t *chair) {
    uint64_t free_um = (uint64_t)ground->free_mm * 1000;
    uint64_t gone_um = (uint64_t)ground->fastest_mm_s * ground->age_ms;
    uint32_t limit = 0;
    uint32_t bit;
    if (ground->age_ms > chair->oldest_ms || chair->deceleration_mm_s2 == 0 || gone_um > free_um) {
        return 0;
    }
    /* An integer square root bit by bit, applied to the whole inequality: the lower of two speeds always stops
     * earlier. */
    /*@ loop assigns bit, limit;
        loop unroll 33;
        loop variant bit; */
    for (bit = (uint32_t)1 << 31; bit > 0; bit >>= 1) {
        if (stops(limit | bit, free_um - gone_um, ground->fastest_mm_s, chair)) {
            limit |= bit;
        }
    }
    return limit;
}
