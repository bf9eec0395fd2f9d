"""Fingers at pseudo-terminals through `ridgetone serve` and mosquitto, and counts that have to add up.

Without --calm, the broker restarts, cables are pulled and bytes are damaged meanwhile. Exits with 1 if a message is
lost without being counted or, with --calm, at all. First: cargo build --release -p ridgetone-host --features mqtt
"""

import argparse, collections, contextlib, itertools, json, os, pathlib, pty, re, signal
import socket, struct, subprocess, tempfile, threading, time, tty, zlib

RATE_HZ = 241.14
CONTACT, REPLY, RAW = 1, 8, 9  # variants of `Event` in crates/proto/src/telemetry/event.rs
AWAY_S, BACK_S = (2, 12, 5), 20  # the broker's absences, and time until its subscriber is back


def varint(value):
    return bytes([value & 127 | 128]) + varint(value >> 7) if value > 127 else bytes([value])


class Board:
    """A board and its cable. It sends frames from the first request on."""

    def __init__(self, path):
        self.path, self.sequence, self.sent, self.damages = path, 0, collections.Counter(), 0
        self.plug()

    def plug(self):
        self.end, port = pty.openpty()
        tty.setraw(port)
        os.set_blocking(self.end, False)
        self.path.symlink_to(os.ttyname(port))
        os.close(port)

    def pull(self):
        self.path.unlink()
        os.close(self.end)
        self.end = -1

    def damage(self):
        self.damages += 1

    def send(self, kind, content):
        plain = varint(self.sequence % 65536) + varint(kind) + content
        plain += zlib.crc32(plain).to_bytes(4, "little")
        wire = bytearray(b"".join(bytes([len(part) + 1]) + part for part in plain.split(b"\0")) + b"\0")  # COBS
        if self.sent["damaged"] < self.damages:
            wire[len(wire) // 2] ^= 0x55
            self.sent["damaged"] += 1
        self.sequence, self.sent[kind] = self.sequence + 1, self.sent[kind] + 1
        with contextlib.suppress(OSError):  # no cable, or nobody reads: lost, as on a real line
            os.write(self.end, wire)

    def tick(self, tick):
        with contextlib.suppress(OSError):
            for request in filter(None, os.read(self.end, 4096).split(b"\0")):
                number = re.match(rb"[\x80-\xff]*[\0-\x7f]", request[1:] if request[0] > 1 else b"\0")[0]
                self.send(REPLY, number + b"\0\0")
        number = self.sent[RAW]
        t_us = varint(round(number / RATE_HZ * 1e6))
        if self.sent[REPLY]:
            self.send(RAW, t_us + varint(number) + 2 * varint(65535) + 16 * varint(4_000_000))
        if tick % 241 == 0:
            self.send(CONTACT, t_us + b"\0" + struct.pack("<f", 1e-3) + t_us)


class Broker:
    def __init__(self, folder):
        self.port = socket.create_server(("127.0.0.1", 0)).getsockname()[1]
        self.configuration, self.restarts = folder / "mosquitto.conf", []
        self.configuration.write_text(f"listener {self.port} 127.0.0.1\nallow_anonymous true\nset_tcp_nodelay true\n")
        self.start()
        self.arrived, self.status = collections.defaultdict(dict), {}  # times by topic and index
        subscribe = f"stdbuf -oL mosquitto_sub -V mqttv5 -q 1 -t ridgetone/# -p {self.port} -F".split() + ["%U %r %t %p"]
        self.subscriber = subprocess.Popen(subscribe, stdout=subprocess.PIPE, text=True)
        threading.Thread(target=self.take, daemon=True).start()

    def start(self):
        self.process = subprocess.Popen(["mosquitto", "-c", self.configuration], stderr=subprocess.DEVNULL)
        while socket.socket().connect_ex(("127.0.0.1", self.port)):
            time.sleep(0.02)

    def stop(self):
        self.restarts.append(time.time())
        self.process.kill()

    def take(self):
        for line in self.subscriber.stdout:
            utc_s, retained, topic, text = line.split(" ", 3)
            index = re.search(r'"index":(\d+)}$', text)
            if topic == "ridgetone/status":
                self.status = json.loads(text)
            elif index and retained == "0":
                self.arrived[topic].setdefault(int(index[1]), float(utc_s))

    def missing(self, topic):
        """Counts the messages of a topic that did not arrive, except those around a restart."""
        arrived = sorted(self.arrived[topic].items())
        return sum(after - before - 1 for (before, before_s), (after, after_s) in zip([(-1, 0), *arrived], arrived)
                   if not any(before_s < at_s + BACK_S and at_s - 2 < after_s for at_s in self.restarts))


def check(board, broker, report):
    """Prints the counts of a board, and yields those that do not add up."""
    name, sent, finger = board.path.name, board.sent, broker.status["fingers"][board.path.name]
    published, lost = finger["published"]["frames"], finger["lost"]["frames"]
    received, on_line, damaged = map(int, re.search(rf"{name}: (\d+) telemetry.* (\d+) lost, (\d+)", report).groups())
    arrived, unconfirmed = len(broker.arrived[f"ridgetone/{name}/frames"]), finger["lost"]["frames_unconfirmed"]
    others, away = on_line - sent[RAW] + published, published - lost - arrived
    print(f"{name}: {board.sequence} packets sent, {on_line} lost on the line, {damaged} damaged; {published} frames "
          f"published, {arrived} arrived, {lost} counted as lost, {away} while the subscriber was away")
    for text, is_right in {
        f"packets: {received} received": 0 <= board.sequence - received - on_line < 10,
        f"lost on the line: {others} packets without a frame": 0 <= others <= sent[REPLY] + sent[CONTACT],
        f"damaged: {sent['damaged']} sent": damaged >= sent["damaged"],
        f"away: {unconfirmed} unconfirmed": 0 <= away <= unconfirmed + 10 * RATE_HZ * len(broker.restarts),
        "lost without a fault": broker.restarts or not on_line + lost + unconfirmed,
    }.items():
        yield from [] if is_right else [f"{name}: {text}"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for name, default in {"minutes": 60.0, "fingers": 2, "command": "target/release/ridgetone"}.items():
        parser.add_argument(f"--{name}", type=type(default), default=default)
    parser.add_argument("--calm", action="store_true")
    args, folder = parser.parse_args(), pathlib.Path(tempfile.mkdtemp())
    os.environ["PATH"] += ":/usr/sbin:/usr/local/sbin"
    broker, boards = Broker(folder), [Board(folder / f"f{number}") for number in range(args.fingers)]
    fingers = [f"--finger={board.path.name}={board.path}" for board in boards]
    command = [args.command, "serve", f"--mqtt=mqtt://127.0.0.1:{broker.port}", *fingers]
    serve, begun, schedule = subprocess.Popen(command, stderr=subprocess.PIPE, text=True), time.time(), []
    starts_s = range(8, int(0 if args.calm else 60 * args.minutes - 40), 40)  # the last faults leave time to recover
    for at_s, board, away_s in zip(starts_s, itertools.cycle(boards), itertools.cycle(AWAY_S)):
        schedule += [(at_s, broker.stop), (at_s + away_s, broker.start), (at_s + 20, board.pull)]
        schedule += [(at_s + 23, board.plug), (at_s + 32, board.damage)]
    for tick in range(int(60 * args.minutes * RATE_HZ)):
        time.sleep(max(0, begun + tick / RATE_HZ - time.time()))
        while schedule and schedule[0][0] < tick / RATE_HZ:
            schedule.pop(0)[1]()
        for board in boards:
            board.tick(tick)
    time.sleep(2)
    serve.send_signal(signal.SIGINT)
    report = serve.stderr.read()
    time.sleep(2)  # until the subscriber has the last message
    wrong = [text for board in boards for text in check(board, broker, report)]
    wrong += [f"{topic}: {count} missing" for topic in broker.arrived if (count := broker.missing(topic))]
    broker.subscriber.kill(), broker.process.kill()
    print(f"{len(broker.restarts)} restarts of the broker", *(wrong or ["all counts add up"]), sep="\n")
    raise SystemExit(bool(wrong))
