"""Speaks lines of standard input with the library of espeak-ng, and tells when each phone begins.

A line is a JSON object: voice, rate, pitch, range, text. The answer is a line of JSON (sampling rate,
number of samples, and for each phone its first sample and its symbol in the IPA), and the samples as
16-bit little-endian numbers. A voice that the library does not have has no sample.
"""
import ctypes
import json
import sys

RETRIEVAL, PHONES_IN_IPA = 1, 3
PHONE, END = 7, 0
RATE, PITCH, RANGE = 1, 3, 4
UTF8 = 1


class Id(ctypes.Union):
    _fields_ = [("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8)]


class Event(ctypes.Structure):
    _fields_ = [
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", Id),
    ]


Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(Event))


def main():
    try:
        library = ctypes.CDLL("libespeak-ng.so.1")
    except OSError:
        sys.exit("libespeak-ng is not installed")
    sound, phones = bytearray(), []

    def spoken(samples, count, events):
        if samples and count > 0:
            sound.extend(ctypes.string_at(samples, 2 * count))
        index = 0
        while events[index].type != END:
            event = events[index]
            if event.type == PHONE:
                symbol = ctypes.string_at(ctypes.addressof(event.id), 8).split(b"\0")[0]
                phones.append([event.sample, symbol.decode("utf-8", "ignore")])
            index += 1
        return 0

    callback = Callback(spoken)
    rate_hz = library.espeak_Initialize(RETRIEVAL, 0, None, PHONES_IN_IPA)
    library.espeak_SetSynthCallback(callback)
    for line in sys.stdin.buffer:
        request = json.loads(line)
        sound.clear()
        phones.clear()
        if library.espeak_SetVoiceByName(request["voice"].encode()) == 0:
            for parameter, name in ((RATE, "rate"), (PITCH, "pitch"), (RANGE, "range")):
                library.espeak_SetParameter(parameter, request[name], 0)
            text = request["text"].encode()
            library.espeak_Synth(text, len(text) + 1, 0, 1, 0, UTF8, None, None)
            library.espeak_Synchronize()
        head = {"rate_hz": rate_hz, "samples": len(sound) // 2, "phones": sorted(phones)}
        sys.stdout.buffer.write(json.dumps(head).encode() + b"\n" + sound)
        sys.stdout.buffer.flush()


main()
