"""Sends the orders to pyxcp, in a separate process because pyxcp reads its configuration from the working folder (pyxcp_conf.py). Prints a
JSON object.

usage: client.py facts | writes | unlocks KEY | record SECONDS EVERY FILE ID..."""

import json
import struct
import sys
import time

from pyxcp.cmdline import ArgumentParser
from pyxcp.daq_stim import DaqList, DaqOnlinePolicy

arguments = sys.argv[1:]
sys.argv = sys.argv[:1]

SIGNALS, PARAMS, REQUESTS, SERVICES = range(4)


class Rows(DaqOnlinePolicy):
    """Keeps the time stamps of the slave and the values."""

    def initialize(self):
        self.stamps = []
        self.values = []

    def on_daq_list(self, daq_list, timestamp0, timestamp1, payload):
        self.stamps.append(timestamp1)
        self.values.append(payload)

    def finalize(self):
        pass


def record(seconds, every, path, ids):
    """Records every n-th period as 32-bit words: first the number of the period, then the floats, row after row. pyxcp orders the floats by
    address."""
    measurements = [("period", 4 * 2000, SIGNALS, "U32")] + [("s%d" % i, 4 * i, SIGNALS, "F32") for i in sorted(ids)]
    policy = Rows([DaqList(name="isr", event_num=0, stim=False, enable_timestamps=True, measurements=measurements,
                           priority=0, prescaler=every)])
    with ArgumentParser(description="").run(policy=policy) as x:
        x.connect()
        policy.setup()
        policy.start()
        while len(policy.stamps) < 10000 * seconds / every:  # seconds by the clock of the drive: a busy machine may take longer
            time.sleep(0.05)
        policy.stop()
        lost = struct.unpack("<I", bytes(x.shortUpload(4, 4 * 1952, SERVICES)))[0]
        x.disconnect()
    with open(path, "wb") as file:
        for row in policy.values:
            file.write(struct.pack("<I%df" % len(ids), *row))
    steps = {}
    for a, b in zip(policy.stamps, policy.stamps[1:]):
        steps[b - a] = steps.get(b - a, 0) + 1
    return {"rows": len(policy.values), "steps": steps, "lost": lost}


def facts():
    """The drive's description of itself, under the names that pyxcp uses."""
    with ArgumentParser(description="").run() as x:
        connected = x.connect()
        x.allocDaq(2)
        processor = x.getDaqProcessorInfo()
        resolution = x.getDaqResolutionInfo()
        event = x.getDaqEventInfo(0)
        done = {
            "version": int(connected.protocolLayerVersion),
            "max_cto": int(connected.maxCto),
            "max_dto": int(connected.maxDto),
            "byte_order": str(connected.commModeBasic.byteOrder),
            "address_granularity": str(connected.commModeBasic.addressGranularity),
            "daq_config_type": str(processor.daqProperties.daqConfigType),
            "prescaler": bool(processor.daqProperties.prescalerSupported),
            "overload_event": bool(processor.daqProperties.overloadEvent),
            "max_daq": int(processor.maxDaq),
            "max_event_channel": int(processor.maxEventChannel),
            "min_daq": int(processor.minDaq),
            "optimisation": str(processor.daqKeyByte.Optimisation_Type),
            "address_extension": str(processor.daqKeyByte.Address_Extension),
            "identification_field": str(processor.daqKeyByte.Identification_Field),
            "granularity": int(resolution.granularityOdtEntrySizeDaq),
            "max_entry": int(resolution.maxOdtEntrySizeDaq),
            "stamp_ticks": int(resolution.timestampTicks),
            "stamp_size": str(resolution.timestampMode.size),
            "stamp_fixed": bool(resolution.timestampMode.fixed),
            "stamp_unit": str(resolution.timestampMode.unit),
            "event_lists": int(event.maxDaqList),
            "event_cycle": int(event.eventChannelTimeCycle),
            "event_unit": str(event.eventChannelTimeUnit),
            "event_priority": int(event.eventChannelPriority),
            "event_name": bytes(x.upload(event.eventChannelNameLength)).decode(),
        }
        x.disconnect()
    return done


def writes():
    """Writes requests and a staged parameter and reads them back; returns also the speed that the motor then has."""

    def put(x, slot, extension, octets):
        x.setMta(4 * slot, extension)
        x.download(octets)

    def get(x, slot, extension, kind):
        return struct.unpack("<" + kind, bytes(x.shortUpload(4, 4 * slot, extension)))[0]

    with ArgumentParser(description="").run() as x:
        x.connect()
        put(x, 11, PARAMS, struct.pack("<f", 8.0))
        put(x, 1003, REQUESTS, struct.pack("<f", 20.0))
        put(x, 1000, REQUESTS, struct.pack("<I", 1 * 0x11111111 ^ 1000 * 0x9E3779B1 & 0xFFFFFFFF))
        read = [get(x, 1000, REQUESTS, "I"), get(x, 1003, REQUESTS, "f"), get(x, 11, PARAMS, "f")]
        speed = 0.0
        for _ in range(400):
            speed = get(x, 2032, SIGNALS, "f")
            if speed > 19.0:
                break
            time.sleep(0.02)
        on = get(x, 2001, SIGNALS, "i")
        put(x, 1000, REQUESTS, struct.pack("<I", 1000 * 0x9E3779B1 & 0xFFFFFFFF))
        time.sleep(0.2)
        off = get(x, 2001, SIGNALS, "i")
        x.disconnect()
    return {"read": read, "states": [on, off], "speed": speed}


def unlocks(key):
    """The protection as the drive reports it and the effect of a write, first locked and then unlocked by the answer to the drive's seed
    (docs/serial.md)."""

    def status(x):
        return bool(x.getStatus().resourceProtectionStatus.calpag)

    def write(x):
        x.setMta(4 * 11, PARAMS)
        try:
            x.download(struct.pack("<f", 8.0))
        except Exception as error:  # pylint: disable=broad-except
            return str(error)
        return ""

    def answer(seed):
        mixed = seed ^ key * 0x9E3779B1 & 0xFFFFFFFF
        for _ in range(4):
            mixed ^= mixed >> 15
            mixed = mixed * 0x2C1B3C6D & 0xFFFFFFFF
            mixed ^= mixed >> 12
            mixed = mixed + key & 0xFFFFFFFF
        return mixed

    with ArgumentParser(description="").run() as x:
        x.connect()
        locked = [status(x), write(x)]
        seed = x.getSeed(0, 0x01)
        x.unlock(4, struct.pack("<I", answer(int.from_bytes(bytes(seed.seed[:4]), "little"))))
        opened = [status(x), write(x)]
        x.disconnect()
    return {"locked": locked, "opened": opened, "length": int(seed.length)}


if arguments[0] == "unlocks":
    done = unlocks(int(arguments[1]))
elif arguments[0] == "record":
    done = record(float(arguments[1]), int(arguments[2]), arguments[3], [int(i) for i in arguments[4:]])
else:
    done = {"facts": facts, "writes": writes}[arguments[0]]()
print(json.dumps(done))
