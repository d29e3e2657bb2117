// A browser, runs to look at, and what can be counted in a picture of a page.

import { spawn, execFileSync } from 'node:child_process';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const program = process.env.FISSURE;
export const folder = mkdtempSync(join(tmpdir(), 'fissure-page-'));

/** A box that falls and breaks between two balls: five frames. */
const SCENE = `
title = "A box breaks"
duration = 0.04

[body.box]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
tets = 900
rotate = { axis = [1, 0, 1], degrees = 30 }
translate = [0, 0.09, 0]
density = 1000
velocity = [0.2, -4, 0]

[body.box.material]
law = "isotropic"
bulk_modulus = 5e5
shear_modulus = 3e5

[body.box.fracture]
criterion = "critical_stretch"
critical_stretch = 0.05

[[collider]]
name = "ball"
shape = { kind = "ball", radius = 0.03 }
position = [-0.12, 0.03, -0.08]

[ground]

[output]
frame_every = 0.01

[output.picture]
width = 64
height = 48
`;

export function fissure(...options) {
  return execFileSync(program, options, { cwd: folder, encoding: 'utf8' });
}

/** Runs the scene into the folder `name`. */
export function run(name, ...options) {
  writeFileSync(join(folder, 'box.toml'), SCENE);
  fissure('run', 'box.toml', '--out', name, '--quiet', ...options);
}

/** Serves runs; gives the address and how to end it. */
export async function view(...runs) {
  const server = spawn(program, ['view', ...runs], { cwd: folder });
  const url = await new Promise((resolve, reject) => {
    server.stdout.once('data', (text) => resolve(String(text).split('\n')[0]));
    server.once('exit', () => reject(new Error('fissure view ended')));
  });
  return { url, end: () => void server.kill() };
}

export const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});

/** Opens a page and waits for its first picture; `said` collects errors and warnings. */
export async function open(url, { width = 900, height = 600 } = {}) {
  const page = await browser.newPage({ viewport: { width, height } });
  const said = [];
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && said.push(message.text()));
  page.on('pageerror', (error) => said.push(String(error)));
  page.on('requestfailed', (request) => said.push(`${request.url().slice(0, 100)} failed`));
  await page.goto(url);
  await page.waitForFunction(() => document.body.dataset.frame !== undefined, null, { timeout: 60_000 });
  return { page, said };
}

/** The number of the frame that is shown. */
export const shown = (page) => page.evaluate(() => Number(document.body.dataset.frame));

/** Waits until frame `number` is shown and drawn. */
export async function until(page, number) {
  await page.waitForFunction((n) => Number(document.body.dataset.frame) === n, number, { timeout: 30_000 });
  await drawn(page);
}

const drawn = (page) => page.evaluate(() => new Promise((done) => {
  requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)));
}));

/** Where pictures are taken apart. */
let paper;

/** Red, green, blue of a picture of the middle of the stage, where no legend lies. */
export async function pixels(page) {
  await drawn(page);
  const box = await page.locator('#stage').boundingBox();
  const clip = { x: box.x, y: box.y + 0.1 * box.height, width: box.width, height: 0.6 * box.height };
  const png = (await page.screenshot({ clip })).toString('base64');
  paper ??= await browser.newPage();
  const data = await paper.evaluate(async (source) => {
    const image = new Image();
    image.src = `data:image/png;base64,${source}`;
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let text = '';
    for (let k = 0; k < data.length; k += 8192) text += String.fromCharCode(...data.subarray(k, k + 8192));
    return btoa(text);
  }, png);
  return Buffer.from(data, 'base64');
}

/** How many pixels of a picture `test(r, g, b)` holds for. */
export function count(data, test) {
  let sum = 0;
  for (let k = 0; k < data.length; k += 4) if (test(data[k], data[k + 1], data[k + 2])) sum += 1;
  return sum;
}

/** How many pixels differ clearly between two pictures. */
export function differing(a, b) {
  let sum = 0;
  for (let k = 0; k < a.length; k += 4) {
    if (Math.abs(a[k] - b[k]) + Math.abs(a[k + 1] - b[k + 1]) + Math.abs(a[k + 2] - b[k + 2]) > 40) sum += 1;
  }
  return sum;
}
