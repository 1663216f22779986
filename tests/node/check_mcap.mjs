// SPDX-License-Identifier: MIT
// Reads an MCAP file by its index and as a stream, CRCs checked, decodes every message by the schema
// beside it, and prints what it found as JSON: node check_mcap.mjs FILE
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader as Ros1Reader } from "@foxglove/rosmsg-serialization";
import { MessageReader as Ros2Reader } from "@foxglove/rosmsg2-serialization";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor/index.js";
import { open, readFile } from "node:fs/promises";

const { FileDescriptorSet } = protobuf.descriptor ?? (await import("protobufjs/ext/descriptor/index.js")).default;

const file = process.argv[2];
const decompressHandlers = await loadDecompressHandlers();

function decoder(channel, schema) {
  const text = schema ? new TextDecoder().decode(schema.data) : "";
  switch (schema?.encoding) {
    case "ros1msg": {
      const reader = new Ros1Reader(parse(text));
      return (data) => reader.readMessage(data);
    }
    case "ros2msg": {
      const reader = new Ros2Reader(parse(text, { ros2: true }));
      return (data) => reader.readMessage(data);
    }
    case "protobuf": {
      const root = protobuf.Root.fromDescriptor(FileDescriptorSet.decode(schema.data));
      root.resolveAll();
      const type = root.lookupType(schema.name);
      return (data) => type.toObject(type.decode(data), { longs: Number, enums: String, bytes: Array });
    }
    default:
      return (data) => [...data];
  }
}

const plain = (value) =>
  JSON.parse(
    JSON.stringify(value, (_, v) =>
      typeof v === "bigint" ? Number(v) : ArrayBuffer.isView(v) ? [...v] : v,
    ),
  );

const shown = (message, decode) => ({
  sequence: message.sequence,
  log_time: message.logTime.toString(),
  publish_time: message.publishTime.toString(),
  message: plain(decode(message.data)),
});

// --- By the index.
const handle = await open(file);
const readable = {
  size: async () => BigInt((await handle.stat()).size),
  read: async (offset, size) => {
    const buffer = new Uint8Array(Number(size));
    const { bytesRead } = await handle.read(buffer, 0, Number(size), Number(offset));
    if (bytesRead !== Number(size)) throw new Error(`read ${bytesRead} bytes instead of ${size}`);
    return buffer;
  },
};
const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const decoders = new Map();
for (const channel of indexed.channelsById.values())
  decoders.set(channel.id, decoder(channel, indexed.schemasById.get(channel.schemaId)));
const byTopic = {};
for await (const message of indexed.readMessages({ validateCrcs: true })) {
  const topic = indexed.channelsById.get(message.channelId).topic;
  (byTopic[topic] ??= []).push(shown(message, decoders.get(message.channelId)));
}
const attachments = [];
for await (const a of indexed.readAttachments({ validateCrcs: true }))
  attachments.push({ name: a.name, media_type: a.mediaType, text: new TextDecoder().decode(a.data) });
const metadata = [];
for await (const m of indexed.readMetadata())
  metadata.push({ name: m.name, values: Object.fromEntries(m.metadata) });
const chunks = indexed.chunkIndexes.map((c) => c.compression);
await handle.close();

// --- As a stream.
const streamed = {};
const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
reader.append(new Uint8Array(await readFile(file)));
const topics = new Map();
let dataEnd = false;
for (let record; (record = reader.nextRecord()); ) {
  if (record.type === "Channel") topics.set(record.id, record.topic);
  if (record.type === "DataEnd") dataEnd = record.dataSectionCrc !== 0;
  if (record.type === "Message") {
    const topic = topics.get(record.channelId);
    streamed[topic] = (streamed[topic] ?? 0) + 1;
  }
}

console.log(
  JSON.stringify({
    header: indexed.header,
    statistics: plain({ ...indexed.statistics, channelMessageCounts: undefined }),
    chunks,
    messages: byTopic,
    streamed,
    stream_done: reader.done(),
    has_data_crc: dataEnd,
    attachments,
    metadata,
  }),
);
